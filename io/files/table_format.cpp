#include "afferent/io/files/table_format.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "afferent/io/files/column_unit.hpp"

namespace afferent {
namespace {

constexpr std::array<std::string_view, 20> time_names{
    "time",     "t",         "timestamp", "timestamps",   "time stamp", "times", "ts",
    "datetime", "date time", "zeit",      "temps",        "tiempo",     "tempo", "elapsed",
    "clock",    "seconds",   "uhrzeit",   "elapsed time", "date",       "datum"};
// The last of them, beside which the time of day may have a column of its own.
constexpr std::span date_names = std::span(time_names).last(2);

std::string quoted_column(std::string_view name) { return '"' + std::string(name) + '"'; }

std::string listed_columns(const std::vector<std::string>& names) {
    constexpr std::size_t most = 12;
    constexpr std::size_t longest = 40;
    std::string list;
    for (std::size_t i = 0; i < std::min(names.size(), most); ++i)
        list += (list.empty() ? "\"" : ", \"") + names[i].substr(0, longest) +
                (names[i].size() > longest ? "…\"" : "\"");
    return names.size() > most ? list + ", …" : list;
}

std::string short_number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.15g", value);
    return text.data();
}

// "Sample time [s]" is time, and "contact time_n" a force.
std::optional<TimeUnit> unit_of_time_column(const std::string& name) {
    const NamedUnit named = named_unit(name);
    const auto unit = time_unit_called(named.unit);
    if (!unit && !named.unit.empty()) return std::nullopt;
    if (std::ranges::find(time_names, std::string_view(named.name)) == time_names.end()) return std::nullopt;
    return named.name == "seconds" ? TimeUnit::seconds : unit.value_or(TimeUnit::found);
}

}  // namespace

char separator_of(std::string_view line) noexcept {
    bool in_quotes = false;
    char found = ' ';
    const auto rank = [](char c) { return c == '\t' ? 3 : c == ';' ? 2 : c == ',' ? 1 : 0; };
    for (const char c : line) {
        if (c == '"') in_quotes = !in_quotes;
        if (!in_quotes && rank(c) > rank(found)) found = c;
    }
    return found;
}

std::variant<TimeColumn, std::string> find_time_column(const std::vector<std::string>& names,
                                                       const TableOptions& options) {
    const auto missing = [&](const std::string& name, const std::string& advice) {
        return "there is no column " + quoted_column(name) + "; the columns are " + listed_columns(names) +
               advice;
    };
    const auto unit_of = [&](std::size_t position) {
        if (options.time_unit != TimeUnit::found) return options.time_unit;
        return time_unit_called(named_unit(names[position]).unit).value_or(TimeUnit::found);
    };
    const auto position_of = [&](const std::string& name) {
        return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
    };
    if (!options.time_column.empty()) {
        const std::size_t position = position_of(options.time_column);
        if (position == names.size()) return missing(options.time_column, "");
        return TimeColumn{position, unit_of(position)};
    }
    if (const std::size_t position = position_of("time_s"); position < names.size())
        return TimeColumn{position, unit_of(position)};
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (unit_of_time_column(names[i])) found.push_back(i);
    if (found.size() == 2) {
        const auto is_date = [&](std::size_t i) {
            return std::ranges::find(date_names, std::string_view(named_unit(names[i]).name)) !=
                   date_names.end();
        };
        if (is_date(found[1])) std::swap(found[0], found[1]);
        if (is_date(found[0]) && !is_date(found[1])) {
            const TimeColumn time{found[1], unit_of(found[1]), found[0]};
            if (time.unit == TimeUnit::found || time.unit >= TimeUnit::date) return time;
            return TimeColumn{time.position, time.unit};
        }
    }
    if (found.size() > 1)
        return "columns " + quoted_column(names[found[0]]) + " and " + quoted_column(names[found[1]]) +
               " may both be time: say which by time_column (--time-column)";
    if (found.empty())
        return missing("time_s",
                       ". Say which is time by time_column (--time-column), or how many rows a second has by "
                       "rate_hz (--rate-hz)");
    const TimeUnit said = *unit_of_time_column(names[found[0]]);
    return TimeColumn{found[0], options.time_unit == TimeUnit::found ? said : options.time_unit};
}

TableClock::TableClock(std::string column, TimeUnit unit, const TableOptions& options)
    : column_(std::move(column)),
      unit_(std::min(unit, TimeUnit::date)),
      unit_is_said_(unit != TimeUnit::found),
      begin_is_said_(options.begin.has_value()),
      begin_(options.begin) {
    if (unit > TimeUnit::date) date_order_ = unit;
}

TableClock::Refusal TableClock::take(const WrittenTime& time, std::string_view text) {
    if (time.order == TimeUnit::found)
        return std::string(text) +
               " may be of that day or of that month: say time_unit (--time-unit day-first or month-first)";
    if (time.order != TimeUnit::date) date_order_ = time.order;
    if (!has_date_) has_date_ = time.has_date;
    if (*has_date_ != time.has_date)
        return std::string(text) + (time.has_date ? " has a date, and the row above has none"
                                                  : " has no date, and the row above has one");
    unit_ = TimeUnit::date;
    unit_is_said_ = true;
    if (time.has_date) return convert(static_cast<long double>(time.ns), text);
    constexpr std::int64_t day_ns = std::int64_t{86400} * 1'000'000'000;
    if (time.ns + day_ns / 2 < time_of_day_ns_) midnights_ns_ += day_ns;
    time_of_day_ns_ = time.ns;
    return convert(static_cast<long double>(midnights_ns_ + time.ns), text);
}

TableClock::Refusal TableClock::take(long double time, std::string_view text) {
    if (unit_ == TimeUnit::found) {
        if (const auto unix_unit = unit_of_unix_time(time); unix_unit && !first_) {
            unit_ = *unix_unit;
        } else if (!first_) {
            first_ = time;
            first_text_ = text;
            return std::nullopt;
        } else {
            const long double step = time - *first_;
            if (step > longest_step_without_unit)
                return "no unit is said, and a step of " + short_number(static_cast<double>(step)) +
                       " may be of milliseconds as well as of seconds: call the column " +
                       quoted_column(column_ + "_ms") + " or " + quoted_column(column_ + "_s") +
                       ", or say time_unit (--time-unit ms)";
            if (auto refusal = settle()) return refusal;
        }
    }
    return convert(time, text);
}

TableClock::Refusal TableClock::settle() {
    if (unit_ != TimeUnit::found || !first_) return std::nullopt;
    unit_ = TimeUnit::seconds;
    return convert(*first_, first_text_);
}

TableClock::Refusal TableClock::convert(long double time, std::string_view text) {
    const std::string unit = unit_ == TimeUnit::date ? "" : std::string(" ") + unit_name(unit_);
    constexpr long double longest_ns = 292.0L * 365.25L * 86400.0L * 1e9L;
    const long double ns = time * nanoseconds_per(unit_);
    if (!(std::fabs(ns) <= longest_ns)) return std::string(text) + unit + " is beyond 292 years";
    const Duration since_zero(std::llround(ns));
    if (!has_time_) since_1970_ = (unit_ == TimeUnit::date && has_date_ == true) || ns >= 1e18L;
    if (!begin_) begin_ = since_zero >= latest_begin || since_1970_ ? since_zero : Duration::zero();
    if (!(std::fabs(ns - static_cast<long double>(begin_->count())) <= longest_ns))
        return std::string(text) + unit + " is beyond 292 years";
    const TimePoint now = scene_start + (since_zero - *begin_);
    if (has_time_ && now <= time_)
        return std::string(text) + unit +
               (now < time_ ? " is before the row above: time runs backwards"
                            : " is the time of the row above too: no sample lasts 0 s");
    if (now < scene_start && !begin_is_said_)
        return "a table begins at 0 s or later, not at " + std::string(text) +
               "; begin_s (--begin-s) says at which time of the table the scene begins";
    has_time_ = true;
    before_ = time_;
    time_ = now;
    return std::nullopt;
}

void TableClock::fill_in(TableFormat& format) const {
    format.time_column = column_;
    format.time_unit = unit_;
    format.unit_is_said = unit_is_said_;
    format.since_1970 = since_1970_;
    format.times_of_day = has_date_ == false;
    format.begin = begin_.value_or(Duration::zero());
}

std::string TableFormat::said_of_left_out_line() const {
    return "The last line, " + std::to_string(left_out_line) +
           ", has no newline and may be cut off: it is left out";
}

std::string TableFormat::said_of_missing() const {
    return missing.text(container.empty() ? "line" : "row") + (missing.rule == Missing::interpolate
                                                                   ? ": straight lines are drawn over them"
                                                                   : ": such rows are left out");
}

const char* TableFormat::said_of_epoch() const noexcept {
    return since_1970 ? " (since 1970)" : times_of_day ? " (since midnight)" : "";
}

std::vector<std::string> TableFormat::sentences() const {
    std::vector<std::string> said;
    if (compressed) said.emplace_back("It is compressed with gzip.");
    if (!container.empty()) {
        said.push_back("It is a file in " + container + ", whose datasets are the columns.");
    } else {
        said.push_back(separator == '\t'  ? "Tabs separate its columns."
                       : separator == ' ' ? "Spaces separate its columns."
                       : separator == ';' ? "Semicolons separate its columns."
                                          : "Commas separate its columns.");
        said.push_back(decimal_mark_line == 0 ? "All of its numbers are whole."
                                              : std::string("The decimal mark is a ") +
                                                    (decimal_mark == ',' ? "comma" : "point") +
                                                    ", as the first number with one has it, in line " +
                                                    std::to_string(decimal_mark_line) + ".");
        if (left_out_line != 0) said.push_back(said_of_left_out_line() + '.');
        if (utf16) said.emplace_back("It is text in UTF-16.");
        if (header_line == 0) said.emplace_back("It has no header: columns are called 1, 2, 3, …");
        if (has_preamble)
            said.push_back(header_line == 0 ? "The lines above its numbers are left out."
                                            : "Its header is line " + std::to_string(header_line) +
                                                  "; what is above it is left out.");
        if (units_line != 0)
            said.push_back("Units of its columns are in line " + std::to_string(units_line) + ".");
        for (std::size_t i = 0; i < std::min<std::size_t>(ignored_columns.size(), 12); ++i)
            said.push_back("Column " + quoted_column(ignored_columns[i]) +
                           " is of text, or empty: it is ignored.");
        if (ignored_columns.size() > 12)
            said.push_back(std::to_string(ignored_columns.size() - 12) + " more columns are ignored.");
    }
    if (missing.rows != 0) said.push_back(said_of_missing() + '.');
    if (time_column.empty()) {
        said.emplace_back("Rows have no time: the rate is as it was said.");
        return said;
    }
    std::string time = "Time is in column " + quoted_column(time_column);
    if (time_unit == TimeUnit::date)
        time += times_of_day          ? ", as times of day."
                : date_column.empty() ? ", as dates."
                                      : ", and the date in column " + quoted_column(date_column) + ".";
    else
        time += std::string(", in ") + unit_name(time_unit) +
                (unit_is_said ? "."
                 : since_1970 ? ", as the size of its numbers says."
                              : ": nothing says otherwise.");
    said.push_back(std::move(time));
    if (begin != Duration::zero())
        said.push_back("The table's time " + short_number(seconds(begin)) + " s" + said_of_epoch() +
                       " is the scene's 0.");
    return said;
}

}  // namespace afferent
