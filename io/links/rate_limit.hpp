// Limits how often something is done: so many times at once, and so many times a second in the long run.
#pragma once

#include <algorithm>
#include <chrono>

namespace afferent {

// A leaky bucket: `due_` is when the bucket would be empty.
class RateLimit {
  public:
    using Time = std::chrono::steady_clock::time_point;

    // Both > 0.
    RateLimit(int per_second, int at_once)
        : interval_(std::chrono::nanoseconds(std::chrono::seconds(1)) / per_second),
          slack_((at_once - 1) * interval_) {}

    // How long it has to wait. Zero: it may be done at once, and is counted.
    std::chrono::nanoseconds take(Time now) {
        const Time due = std::max(due_, now);
        if (due - now > slack_) return due - now - slack_;
        due_ = due + interval_;
        return std::chrono::nanoseconds::zero();
    }

  private:
    std::chrono::nanoseconds interval_;
    std::chrono::nanoseconds slack_;
    Time due_{};
};

}  // namespace afferent
