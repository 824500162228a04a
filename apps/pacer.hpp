// Keeps scene time to the wall clock. This belongs to the program: the library reads no clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "afferent/runtime/time.hpp"

namespace afferent {

class Pacer {
  public:
    using Clock = std::chrono::steady_clock;

    // A step that is later than this has missed its deadline, because the controller's next one is due.
    static constexpr Duration tolerance = 1ms;

    explicit Pacer(Clock::time_point start = Clock::now()) : start_(start) {}

    Clock::time_point wall(TimePoint time) const { return start_ + time.time_since_epoch(); }
    TimePoint now() const {
        return scene_start + std::chrono::duration_cast<Duration>(Clock::now() - start_);
    }

    // To be called when the step that was due at `time` is done.
    void did(TimePoint time) {
        const Duration lag = now() - time;
        worst_ = std::max(worst_, lag);
        if (lag > tolerance) ++missed_;
    }

    std::uint64_t missed_deadlines() const noexcept { return missed_; }
    Duration worst_lag() const noexcept { return worst_; }

  private:
    Clock::time_point start_;
    std::uint64_t missed_ = 0;
    Duration worst_{};
};

}  // namespace afferent
