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
    // One digit, or two.
    int short_number() noexcept {
        const int first = digit();
        const int second = first < 0 ? -1 : digit();
        return second < 0 ? first : 10 * first + second;
    }
    // Letters of either case, in capitals here.
    bool take_word(std::string_view word) noexcept {
        if (text_.size() < word.size()) return false;
        for (std::size_t i = 0; i < word.size(); ++i)
            if ((text_[i] & ~0x20) != word[i]) return false;
        text_.remove_prefix(word.size());
        return true;
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

// "14:03", "14:03:07.125" or "2:03:07 PM", as nanoseconds since midnight.
std::optional<std::int64_t> time_of_day_ns(Cursor& at, bool needs_seconds) noexcept {
    int hour = at.short_number();
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
    } else if (needs_seconds) {
        return std::nullopt;
    }
    if (at.front() == ' ') {
        at.take(" ");
        const bool afternoon = at.take_word("PM");
        if ((!afternoon && !at.take_word("AM")) || hour < 1 || hour > 12) return std::nullopt;
        hour = hour % 12 + (afternoon ? 12 : 0);
    }
    return ((std::int64_t{hour} * 60 + minute) * 60 + second) * ns_per_s + ns;
}

struct DateOfYear {
    int year = 0;
    int month = 0;
    int day = 0;
    TimeUnit order = TimeUnit::date;
};

// The parts of a date are separated by "-", "/" or ".", the same one twice. `order`: day or month first, if
// known.
std::optional<DateOfYear> date_of_year(std::string_view text, Cursor& at, TimeUnit order) noexcept {
    DateOfYear date;
    const bool year_first =
        text.size() > 4 && text.substr(0, 4).find_first_of("-/.") == std::string_view::npos;
    if (year_first) {
        date.year = at.number(4);
        const char mark = at.front();
        if (!at.take("-/.")) return std::nullopt;
        date.month = at.short_number();
        if (!at.take({&mark, 1})) return std::nullopt;
        date.day = at.short_number();
        return date;
    }
    const int first = at.short_number();
    const char mark = at.front();
    if (!at.take("-/.")) return std::nullopt;
    const int second = at.short_number();
    if (!at.take({&mark, 1})) return std::nullopt;
    date.year = at.number(4);
    if (order != TimeUnit::day_first && order != TimeUnit::month_first)
        order = mark == '.' || first > 12 ? TimeUnit::day_first
                : second > 12             ? TimeUnit::month_first
                : first == second         ? TimeUnit::date
                                          : TimeUnit::found;
    date.order = order;
    date.day = order == TimeUnit::month_first ? second : first;
    date.month = order == TimeUnit::month_first ? first : second;
    return date;
}

}  // namespace

std::optional<TimeUnit> time_unit_called(std::string_view unit) {
    const auto* const called = std::ranges::find(called_units, unit, &CalledUnit::name);
    return called == called_units.end() ? std::nullopt : std::optional(called->unit);
}

const char* unit_name(TimeUnit unit) noexcept {
    constexpr std::array names{"s", "s", "ms", "µs", "ns", "min", "date", "date", "date"};
    return names[static_cast<std::size_t>(unit)];
}

long double nanoseconds_per(TimeUnit unit) noexcept {
    constexpr std::array<long double, 9> factors{1e9L, 1e9L, 1e6L, 1e3L, 1, 60e9L, 1, 1, 1};
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

std::optional<WrittenTime> parse_time(std::string_view text, TimeUnit order) noexcept {
    Cursor at(text);
    if (text.find_first_of("-/") > 4 && text.find('.') > 4) {
        const auto ns = time_of_day_ns(at, true);
        if (!ns || !at.empty()) return std::nullopt;
        return WrittenTime{.ns = *ns, .has_date = false};
    }
    const auto written = date_of_year(text, at, order);
    if (!written || written->year < 1700 || written->year > 2200 || written->month < 1 || written->day < 1 ||
        !at.take("Tt "))
        return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year(written->year),
                                           std::chrono::month(static_cast<unsigned>(written->month)),
                                           std::chrono::day(static_cast<unsigned>(written->day))};
    if (!date.ok()) return std::nullopt;
    const auto ns = time_of_day_ns(at, false);
    const auto offset = ns ? offset_s(at) : std::nullopt;
    if (!offset || !at.empty()) return std::nullopt;
    const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
    return WrittenTime{.ns = (days * 86400 - *offset) * ns_per_s + *ns, .order = written->order};
}

}  // namespace afferent
