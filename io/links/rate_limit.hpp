// At most so many of a kind in a second.
#pragma once

#include <algorithm>
#include <chrono>

namespace afferent {

// What was not used is saved up for one second.
class RateLimit {
  public:
    using Time = std::chrono::steady_clock::time_point;

    explicit RateLimit(double per_second) : per_second_(per_second), left_(per_second) {}

    bool take(Time now) {
        const std::chrono::duration<double> passed = now - last_;
        last_ = now;
        left_ = std::min(per_second_, left_ + std::max(0.0, passed.count()) * per_second_);
        if (left_ < 1) return false;
        left_ -= 1;
        return true;
    }

  private:
    double per_second_;
    double left_;
    Time last_{};
};

}  // namespace afferent
