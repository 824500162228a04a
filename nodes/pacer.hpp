// Keeps scene time in step with a monotonic clock, or with the clock of a peer. It reads no clock: every call
// is given the time.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

class Pacer {
  public:
    // A step that is later than this has missed its deadline, because the controller's next one is due.
    static constexpr Duration tolerance = 1ms;
    // Faster than two clocks drift apart, and too slow for anyone to notice.
    static constexpr double most_correction = 2000e-6;

    // At `now` it is `time` in the scene, which runs `speed` times as fast as the clock.
    explicit Pacer(MonotonicTime now, TimePoint time = scene_start, double speed = 1)
        : now_(now), time_(time), speed_(speed) {}

    // The first nanosecond at which scene_time() has come so far: whoever waits until then is not early.
    MonotonicTime wall(TimePoint time) const {
        MonotonicTime now = now_ + std::chrono::duration_cast<Duration>(Interval(time - time_) / speed_);
        while (scene_time(now) < time) now += Duration(1);
        return now;
    }
    TimePoint scene_time(MonotonicTime now) const {
        return time_ + std::chrono::duration_cast<Duration>(Interval(now - now_) * speed_);
    }

    // At `now` the peer's scene time is ahead of ours by this much. From here on ours runs faster or slower,
    // until the next call, so that it comes closer. It never stops, jumps or runs backwards. Where it is not
    // known, ours runs as the clock does. A proportional-integral controller, critically damped: a peer whose
    // clock keeps drifting is not followed at a distance, and is at most 0.8 ms away for each 1000 ppm of a
    // drift that begins.
    void steer(MonotonicTime now, std::optional<Duration> ahead) {
        const double since_s = std::min(Seconds(now - now_), Seconds(1s)).count();
        time_ = scene_time(now);
        now_ = now;
        const double ahead_s = Seconds(ahead.value_or(Duration::zero())).count();
        if (!ahead) drift_ = 0;
        const double wanted = drift_ + ahead_s;
        const double correction = std::clamp(wanted, -most_correction, most_correction);
        // At the limit nothing is learnt of the drift.
        if (wanted == correction) drift_ += ahead_s * since_s / 4;
        speed_ = 1 + correction;
    }

    // How long what was due at `time` has been due.
    Duration lag(TimePoint time, MonotonicTime now) const { return scene_time(now) - time; }

    // What was due at `time` is done.
    void did(TimePoint time, MonotonicTime now) {
        const Duration lag = this->lag(time, now);
        worst_ = std::max(worst_, lag);
        if (lag > tolerance) ++missed_;
    }

    std::uint64_t missed_deadlines() const noexcept { return missed_; }
    Duration worst_lag() const noexcept { return worst_; }

  private:
    MonotonicTime now_;
    TimePoint time_;
    double speed_;
    double drift_ = 0;  // of the peer's clock
    std::uint64_t missed_ = 0;
    Duration worst_{};
};

}  // namespace afferent
