// Units of time in tables, and dates as text. Included by whoever builds a scene with tables.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace afferent {

enum class TimeUnit { found, seconds, milliseconds, microseconds, nanoseconds, minutes, date };

// The unit with that name in lower case: "s", "ms", "us", "min", ...
std::optional<TimeUnit> time_unit_called(std::string_view unit);
// "s", "ms", "µs", "ns", "min"; "date" for dates.
const char* unit_name(TimeUnit unit) noexcept;
// The length of one unit in nanoseconds; 1 for dates, which are parsed to nanoseconds.
long double nanoseconds_per(TimeUnit unit) noexcept;

// Infers the unit of a time since 1970 from its size: 1e9 to 1e10 are seconds in the years 2001 to 2286, 1e12
// to 1e13 milliseconds, and so on. Empty for any other number.
std::optional<TimeUnit> unit_of_unix_time(long double time) noexcept;

// Nanoseconds since 1970 of "2026-11-22T14:03:07.125Z" (ISO 8601). Accepts a space in place of the T and a
// comma in place of the point. Seconds may be absent, and so may the offset from UTC ("+01:00"): the time is
// then UTC. Empty for any other text.
std::optional<std::int64_t> parse_date(std::string_view text) noexcept;

}  // namespace afferent
