#include "afferent/io/files/time_unit.hpp"

#include <algorithm>
#include <array>
#include <chrono>

namespace afferent {
namespace {

struct CalledUnit {
    std::string_view name;
    TimeUnit unit;
};
constexpr std::array called_units{
    CalledUnit{"s", TimeUnit::seconds}, CalledUnit{"sec", TimeUnit::seconds},
    CalledUnit{"secs", TimeUnit::seconds}, CalledUnit{"second", TimeUnit::seconds},
    CalledUnit{"seconds", TimeUnit::seconds}, CalledUnit{"ms", TimeUnit::milliseconds},
    CalledUnit{"msec", TimeUnit::milliseconds}, CalledUnit{"millis", TimeUnit::milliseconds},
    CalledUnit{"milliseconds", TimeUnit::milliseconds}, CalledUnit{"us", TimeUnit::microseconds},
    CalledUnit{"usec", TimeUnit::microseconds}, CalledUnit{"micros", TimeUnit::microseconds},
    CalledUnit{"microseconds", TimeUnit::microseconds},
    // The micro sign and the Greek letter in UTF-8, and the sign in Latin-1.
    CalledUnit{"\xC2\xB5s", TimeUnit::microseconds}, CalledUnit{"\xCE\xBCs", TimeUnit::microseconds},
    CalledUnit{"\xB5s", TimeUnit::microseconds}, CalledUnit{"ns", TimeUnit::nanoseconds},
    CalledUnit{"nanos", TimeUnit::nanoseconds}, CalledUnit{"nanoseconds", TimeUnit::nanoseconds},
    CalledUnit{"min", TimeUnit::minutes}, CalledUnit{"minutes", TimeUnit::minutes}};

// Takes what it reads from the front of the text.
class Cursor {
  public:
    explicit Cursor(std::string_view text) noexcept : text_(text) {}

    bool empty() const noexcept { return text_.empty(); }
    bool take(std::string_view any_of) noexcept {
        if (text_.empty() || any_of.find(text_.front()) == std::string_view::npos) return false;
        text_.remove_prefix(1);
        return true;
    }
    // Exactly so many digits; -1 if there are fewer.
    int number(int digits) noexcept {
        int value = 0;
        for (int i = 0; i < digits; ++i) {
            const int digit = this->digit();
            if (digit < 0) return -1;
            value = 10 * value + digit;
        }
        return value;
    }
    int digit() noexcept {
        if (text_.empty() || text_.front() < '0' || text_.front() > '9') return -1;
        const int value = text_.front() - '0';
        text_.remove_prefix(1);
        return value;
    }
    char front() const noexcept { return text_.empty() ? '\0' : text_.front(); }

  private:
    std::string_view text_;
};

constexpr std::int64_t ns_per_s = 1'000'000'000;

// Behind the point: digits beyond the ninth are dropped.
std::optional<std::int64_t> fraction_ns(Cursor& at) noexcept {
    std::int64_t ns = 0;
    std::int64_t place = ns_per_s / 10;
    bool any = false;
    for (int digit = at.digit(); digit >= 0; digit = at.digit()) {
        ns += place * digit;
        place /= 10;
        any = true;
    }
    return any ? std::optional(ns) : std::nullopt;
}

// From UTC, in seconds.
std::optional<std::int64_t> offset_s(Cursor& at) noexcept {
    if (at.empty() || at.take("Zz")) return 0;
    const bool west = at.front() == '-';
    if (!at.take("+-")) return std::nullopt;
    const int hours = at.number(2);
    at.take(":");
    const int minutes = at.empty() ? 0 : at.number(2);
    if (hours < 0 || hours > 15 || minutes < 0 || minutes > 59) return std::nullopt;
    const std::int64_t offset = 3600 * std::int64_t{hours} + 60 * std::int64_t{minutes};
    return west ? -offset : offset;
}

}  // namespace

std::optional<TimeUnit> time_unit_called(std::string_view unit) {
    const auto* const called = std::ranges::find(called_units, unit, &CalledUnit::name);
    return called == called_units.end() ? std::nullopt : std::optional(called->unit);
}

const char* unit_name(TimeUnit unit) noexcept {
    constexpr std::array names{"s", "s", "ms", "µs", "ns", "min", "date"};
    return names[static_cast<std::size_t>(unit)];
}

long double nanoseconds_per(TimeUnit unit) noexcept {
    constexpr std::array<long double, 7> factors{1e9L, 1e9L, 1e6L, 1e3L, 1, 60e9L, 1};
    return factors[static_cast<std::size_t>(unit)];
}

std::optional<TimeUnit> unit_of_unix_time(long double time) noexcept {
    const auto from = [time](long double first) { return time >= first && time < 10 * first; };
    if (from(1e9L)) return TimeUnit::seconds;
    if (from(1e12L)) return TimeUnit::milliseconds;
    if (from(1e15L)) return TimeUnit::microseconds;
    if (from(1e18L)) return TimeUnit::nanoseconds;
    return std::nullopt;
}

std::optional<std::int64_t> parse_date(std::string_view text) noexcept {
    Cursor at(text);
    const int year = at.number(4);
    if (year < 1700 || year > 2200 || !at.take("-/")) return std::nullopt;
    const int month = at.number(2);
    if (month < 1 || !at.take("-/")) return std::nullopt;
    const int day = at.number(2);
    if (day < 1 || !at.take("Tt ")) return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year(year),
                                           std::chrono::month(static_cast<unsigned>(month)),
                                           std::chrono::day(static_cast<unsigned>(day))};
    if (!date.ok()) return std::nullopt;
    const int hour = at.number(2);
    if (hour < 0 || hour > 23 || !at.take(":")) return std::nullopt;
    const int minute = at.number(2);
    if (minute < 0 || minute > 59) return std::nullopt;
    int second = 0;
    std::int64_t ns = 0;
    if (at.take(":")) {
        second = at.number(2);
        if (second < 0 || second > 60) return std::nullopt;
        if (at.take(".,")) {
            const auto fraction = fraction_ns(at);
            if (!fraction) return std::nullopt;
            ns = *fraction;
        }
    }
    const auto offset = offset_s(at);
    if (!offset || !at.empty()) return std::nullopt;
    const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
    return ((days * 24 + hour) * 3600 + std::int64_t{60} * minute + second - *offset) * ns_per_s + ns;
}

}  // namespace afferent
