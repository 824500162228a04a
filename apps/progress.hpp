// Shows the progress of a long command on standard error, once it has taken two seconds.
#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <string>

namespace afferent {

class Progress {
  public:
    explicit Progress(std::string what)
        : what_(std::move(what)), next_(Clock::now() + std::chrono::seconds(2)) {}
    ~Progress() {
        if (shown_ && terminal_) std::fputs("\r\033[K", stderr);
    }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // The fraction that is done.
    void at(double fraction) {
        const auto now = Clock::now();
        if (now < next_) return;
        next_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(10));
        std::fprintf(stderr, terminal_ ? "\r%s: %.0f %% " : "%s: %.0f %%\n", what_.c_str(), 100 * fraction);
        std::fflush(stderr);
        shown_ = true;
    }

  private:
    using Clock = std::chrono::steady_clock;
    std::string what_;
    Clock::time_point next_;
    bool terminal_ = isatty(STDERR_FILENO) == 1;
    bool shown_ = false;
};

}  // namespace afferent
