// Where the time of a rank goes.
#pragma once

#include <ctime>

#include "afferent/nodes/ranks/messages.hpp"
#include "afferent/nodes/ranks/patience.hpp"

namespace afferent::ranks {

// The processor time of this process, of all its threads. Other load on the machine does not count.
inline double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Told what a rank does, one thing after another, it adds up the times of a report.
class Stopwatch {
  public:
    explicit Stopwatch(Report& report) : report_(report) {}

    // The rank begins to compute, to wait, or to do something else.
    void computes() { next(Doing::computing); }
    void waits() { next(Doing::waiting); }
    void does_the_rest() { next(Doing::the_rest); }
    // At its end.
    void stop() {
        does_the_rest();
        report_.run_s = std::chrono::duration<double>(since_ - opened_).count();
    }

  private:
    enum class Doing { the_rest, computing, waiting };

    void next(Doing doing) {
        const auto now = Clock::now();
        const double now_s = processor_s();
        if (doing_ == Doing::waiting) report_.wait_s += std::chrono::duration<double>(now - since_).count();
        if (doing_ == Doing::computing) report_.compute_s += now_s - since_s_;
        if (doing_ == Doing::the_rest) report_.rest_s += now_s - since_s_;
        doing_ = doing;
        since_ = now;
        since_s_ = now_s;
    }

    Report& report_;
    Doing doing_ = Doing::the_rest;
    Clock::time_point opened_ = Clock::now();
    Clock::time_point since_ = opened_;
    double since_s_ = processor_s();
};

}  // namespace afferent::ranks
