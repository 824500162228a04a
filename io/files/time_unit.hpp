// The units in which tables tell time, and times of day as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace afferent {

enum class TimeUnit { found, seconds, milliseconds, microseconds, nanoseconds, minutes, date };

// By the name of the unit, in lower case: "s", "ms", "us", "min", ...
std::optional<TimeUnit> time_unit_called(std::string_view unit);
// "s", "ms", "µs", "ns", "min"; "date" for a date, which has none.
const char* unit_name(TimeUnit unit) noexcept;
// The length of one unit; 1 for a date, which is read in nanoseconds.
long double nanoseconds_per(TimeUnit unit) noexcept;

// A time since 1970 without a unit, by its size: 1e9 to 1e10 are the seconds of the years 2001 to 2286, a
// thousand times as many their milliseconds, and so on. Nothing for any other number.
std::optional<TimeUnit> unit_of_unix_time(long double time) noexcept;

// Nanoseconds since 1970 of "2026-11-22T14:03:07.125Z" (ISO 8601). A space may stand for the T, a comma for
// the point; seconds and the offset from UTC ("+01:00") may be absent: then it is UTC. Nothing if the text is
// anything else.
std::optional<std::int64_t> parse_date(std::string_view text) noexcept;

}  // namespace afferent
