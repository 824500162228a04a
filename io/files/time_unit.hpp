// What a user says about a table: its unit of time, dates as text, and what to do about missing values.
// Included by whoever builds a scene with tables.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace afferent {

enum class Missing {
    refuse,
    skip,         // the rows in which they are
    interpolate,  // along a straight line
};

enum class TimeUnit {
    found,
    seconds,
    milliseconds,
    microseconds,
    nanoseconds,
    minutes,
    date,       // or time of day
    day_first,  // dates in that order: 22/11/2026
    month_first
};

// The unit with that name in lower case: "s", "ms", "us", "min", ...
std::optional<TimeUnit> time_unit_called(std::string_view unit);
// "s", "ms", "µs", "ns", "min"; "date" for dates in any order.
const char* unit_name(TimeUnit unit) noexcept;
// The length of one unit in nanoseconds; 1 for dates, which are parsed to nanoseconds.
long double nanoseconds_per(TimeUnit unit) noexcept;

// Infers the unit of a time since 1970 from its size: 1e9 to 1e10 are seconds in the years 2001 to 2286, 1e12
// to 1e13 milliseconds, and so on. Empty for any other number.
std::optional<TimeUnit> unit_of_unix_time(long double time) noexcept;

// A date with its time of day, or a time of day alone. A time without an offset from UTC ("+01:00") is UTC.
struct WrittenTime {
    std::int64_t ns = 0;  // since 1970, or since midnight
    bool has_date = true;
    // How its date is written: `date` with the year first, day_first or month_first. With `found` either
    // order makes a date, as in 03/04/2026.
    TimeUnit order = TimeUnit::date;
};

// Understands "2026-11-22T14:03:07.125Z" (ISO 8601) and what spreadsheets make of it: "2026/11/22 14:03",
// "22.11.2026 14:03:07,125" (with points the day is first), "11/22/2026 2:03:07 PM", "14:03:07.25". `order`
// is that of dates which begin with a day or a month, where it is known. Empty for any other text.
std::optional<WrittenTime> parse_time(std::string_view text, TimeUnit order = TimeUnit::found) noexcept;

}  // namespace afferent
