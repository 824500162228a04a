// Keeps scene time to a monotonic clock. It reads none: it is told what time it is.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "afferent/io/links/watchdog.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

class Pacer {
  public:
    // A step that is later than this has missed its deadline, because the controller's next one is due.
    static constexpr Duration tolerance = 1ms;

    // `start` is when the scene started, or would have.
    explicit Pacer(MonotonicTime start) : start_(start) {}

    MonotonicTime wall(TimePoint time) const { return start_ + time.time_since_epoch(); }
    TimePoint scene_time(MonotonicTime now) const {
        return scene_start + std::chrono::duration_cast<Duration>(now - start_);
    }

    // What was due at `time` is done.
    void did(TimePoint time, MonotonicTime now) {
        const Duration lag = scene_time(now) - time;
        worst_ = std::max(worst_, lag);
        if (lag > tolerance) ++missed_;
    }

    std::uint64_t missed_deadlines() const noexcept { return missed_; }
    Duration worst_lag() const noexcept { return worst_; }

  private:
    MonotonicTime start_;
    std::uint64_t missed_ = 0;
    Duration worst_{};
};

}  // namespace afferent
