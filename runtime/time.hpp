// Scene time in integer nanoseconds. Included by all programs.
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace afferent {

using namespace std::chrono_literals;

using Duration = std::chrono::nanoseconds;

// The clock of a scene. It has no now(): callers pass the time to the runtime.
struct SceneClock {
    using rep = Duration::rep;
    using period = Duration::period;
    using duration = Duration;
    using time_point = std::chrono::time_point<SceneClock, Duration>;
    static constexpr bool is_steady = true;
};

using TimePoint = SceneClock::time_point;

// A real-valued span, for formulas. Use it for short spans only: a long one loses its nanoseconds.
using Interval = std::chrono::duration<double, std::nano>;
using Milliseconds = std::chrono::duration<double, std::milli>;
using Seconds = std::chrono::duration<double>;

inline constexpr TimePoint scene_start{};

// Half-open: [begin, end).
struct TimeSpan {
    TimePoint begin;
    TimePoint end;

    friend bool operator==(const TimeSpan&, const TimeSpan&) = default;
};

// For printing and plotting only: not exact.
constexpr double seconds(TimePoint t) { return Seconds(t.time_since_epoch()).count(); }
constexpr double seconds(Duration d) { return Seconds(d).count(); }

// Rounds to the nearest nanosecond. Requires a finite span below 292 years.
inline Duration rounded(Interval span) { return Duration(std::llround(span.count())); }
inline Duration from_seconds(double seconds) { return rounded(Seconds(seconds)); }
inline Duration from_milliseconds(double milliseconds) { return rounded(Milliseconds(milliseconds)); }

// The time of the k-th sample at a rate, without drift; exact if the period is a whole number of nanoseconds.
inline TimePoint sample_time(std::uint64_t k, double rate_hz) {
    return scene_start + rounded(Interval(static_cast<double>(k) * (1e9 / rate_hz)));
}

}  // namespace afferent
