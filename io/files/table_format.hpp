// What a table is taken for: what separates its columns, its decimal mark, its column of time and where its
// time begins. docs/tables.md states the rules.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "afferent/io/files/missing_values.hpp"
#include "afferent/io/files/time_unit.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// What a reader is told about a table, in place of finding it out.
struct TableOptions {
    std::vector<std::string> columns = {};  // none: all but that of time
    std::string time_column = {};           // empty: by its name
    TimeUnit time_unit = TimeUnit::found;
    // Rows have no time: they are so many a second.
    std::optional<double> rate_hz = {};
    // The table's time that becomes 0; rows before it are skipped. None: that of its first row, where it is
    // `latest_begin` or later.
    std::optional<Duration> begin = {};
    // What to do where a value is missing.
    Missing missing = Missing::refuse;
    // The first line is one, whatever it looks like.
    bool has_header = false;
};

// A table that begins earlier than this keeps its times: nothing is known of the stretch before its first
// row.
inline constexpr Duration latest_begin = 10s;

// Steps between rows that are no longer than this are of seconds, where nothing says the unit.
inline constexpr long double longest_step_without_unit = 0.1L;

struct TableFormat {
    char separator = ',';  // ' ': any number of spaces and tabs
    char decimal_mark = '.';
    std::size_t decimal_mark_line = 0;  // the first line in which a number has one; 0: none has
    std::size_t header_line = 0;        // 0: there is none, and columns are called 1, 2, 3, ...
    std::string time_column;            // empty: rows have no time
    TimeUnit time_unit = TimeUnit::seconds;
    bool unit_is_said = true;      // by the name of the column or by the options
    bool since_1970 = false;       // times of day
    Duration begin{};              // what was subtracted from all times
    bool times_of_day = false;     // without a date
    std::string date_column = {};  // beside that of time; empty: there is none
    bool compressed = false;       // with gzip
    bool utf16 = false;
    bool has_preamble = false;   // lines above the header, which are left out
    std::size_t units_line = 0;  // the line below the header that has the units of its columns; 0: none has
    std::vector<std::string> ignored_columns = {};  // of text, or empty
    MissingValues missing = {};
    bool is_cut = false;  // only the first rows are read
    // The last line has no newline and may have lost digits: it is left out. 0: it has one.
    std::size_t left_out_line = 0;
    std::string container = {};  // "HDF5", "NPZ" or "NPY", where it is no text

    std::string said_of_left_out_line() const;
    std::string said_of_missing() const;
    // " (since 1970)", " (since midnight)" or nothing: what the times of its own count from.
    const char* said_of_epoch() const noexcept;
    // A sentence for each of these, for people.
    std::vector<std::string> sentences() const;
};

// Comma, semicolon, tab or space: the first of tab, semicolon and comma that is in the line outside of
// quotation marks, and otherwise spaces.
char separator_of(std::string_view line) noexcept;

// What of a header is time: the column's position, its unit if its name has one. Or why that cannot be said.
struct TimeColumn {
    std::size_t position;
    TimeUnit unit = TimeUnit::found;
    // The column of the date, where that of time has the time of day alone.
    std::optional<std::size_t> date_position = {};
};
std::variant<TimeColumn, std::string> find_time_column(const std::vector<std::string>& names,
                                                       const TableOptions& options);

// From the times of rows, as they are written, to scene time. Rows are given one after another.
class TableClock {
  public:
    TableClock(std::string column, TimeUnit unit, const TableOptions& options);

    // Says why a time is refused; nothing where it is taken.
    using Refusal = std::optional<std::string>;

    // `text` is for messages.
    Refusal take(long double time, std::string_view text);
    Refusal take(const WrittenTime& time, std::string_view text);
    // Whether dates begin with the day or the month; `found` until a date has decided it.
    TimeUnit date_order() const noexcept { return date_order_; }
    // Several rows share one time: the unit cannot be told before the second row.
    bool is_certain() const noexcept { return unit_ != TimeUnit::found; }
    TimeUnit unit() const noexcept { return unit_; }
    // The input has ended after one row.
    Refusal settle();

    // The times of the row taken last and of the one before it, once certain. Before 0: the row is to be
    // skipped.
    TimePoint time() const noexcept { return time_; }
    TimePoint time_before() const noexcept { return before_; }

    void fill_in(TableFormat& format) const;

  private:
    Refusal convert(long double time, std::string_view text);

    std::string column_;
    TimeUnit unit_;
    bool unit_is_said_;
    bool begin_is_said_;
    TimeUnit date_order_ = TimeUnit::found;
    bool since_1970_ = false;
    std::optional<bool> has_date_;  // where times are written as such
    std::int64_t time_of_day_ns_ = 0;
    std::int64_t midnights_ns_ = 0;     // that have passed since the first time of day
    std::optional<long double> first_;  // while the unit is not certain
    std::string first_text_;
    std::optional<Duration> begin_;
    bool has_time_ = false;
    TimePoint time_{};
    TimePoint before_{};
};

}  // namespace afferent
