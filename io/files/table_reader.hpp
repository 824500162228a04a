// Reads a table of text as its bytes arrive, so that the same code reads a file and standard input.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/io/files/missing_values.hpp"
#include "afferent/io/files/table_error.hpp"
#include "afferent/io/files/table_format.hpp"
#include "afferent/io/files/utf16_text.hpp"
#include "afferent/runtime/time.hpp"

struct csv_parser;

namespace afferent {

// A table is a header and at least one row; time rises from row to row, by any steps. How it is written is
// found out from its first lines (table_format.hpp): the header may have other lines above it, and the units
// of its columns below it. Every number in a wanted column is finite, or missing, as TableOptions says; other
// columns may hold anything, and a column of text is no wanted one unless it is named. Lines that begin with
// # or % are comments. Every line ends in a newline: a last line without one may have lost digits and still
// look like a number, so it is left out (TableFormat).
class TableReader {
  public:
    using OnRow = RowCompleter::OnRow;

    // Longer lines are refused, so that no input takes more memory than this. It is enough for a value from
    // each tactile afferent of a body.
    static constexpr std::size_t longest_line = std::size_t{4} << 20U;
    // The header is among so many lines.
    static constexpr std::size_t most_head_lines = 100;
    // So many rows wait at most for a column whose fields are empty to show what it holds.
    static constexpr std::size_t most_undecided_rows = 100;

    // The name begins every message.
    explicit TableReader(std::string name, TableOptions options = {});
    TableReader(std::string name, std::vector<std::string> wanted)
        : TableReader(std::move(name), TableOptions{.columns = std::move(wanted)}) {}

    // Hands over the rows that end in these bytes. After the first error nothing more is read, and every call
    // returns that error.
    [[nodiscard]] std::optional<TableError> feed(std::string_view bytes, const OnRow& on_row);
    // The input has ended. Hands over the only row of a table whose unit of time a second row would have
    // told.
    [[nodiscard]] std::optional<TableError> finish(const OnRow& on_row);
    [[nodiscard]] std::optional<TableError> finish() {
        return finish([](const TableRow&) {});
    }

    // The names of the values of a row. Empty before the header has been read.
    const std::vector<std::string>& columns() const noexcept { return columns_; }
    const std::string& name() const noexcept { return name_; }
    // What the table is taken for, by what has been read of it.
    TableFormat format() const;

  private:
    struct FreeParser {
        void operator()(csv_parser* parser) const noexcept;
    };
    // Says what is wrong with the current line, if anything is.
    using Refusal = std::optional<std::string>;

    Refusal take(std::string_view bytes, const OnRow& on_row);
    Refusal take_bytes(std::string_view bytes, const OnRow& on_row);
    Refusal take_text(std::string_view text, const OnRow& on_row);
    Refusal read_line(std::string_view line, const OnRow& on_row);
    bool is_comment(std::string_view line);
    Refusal split(std::string_view line);
    void split_at_spaces(std::string_view line);
    void use_separator(char separator);
    // The lines up to the first row.
    Refusal read_head(std::string_view line, const OnRow& on_row);
    // True: the line above, which may be the header, has this line's fields below it.
    bool is_below_header() const;
    // By the separator that the line itself shows, unless it is known.
    Refusal split_head(std::string_view line);
    bool is_row_of_numbers();
    // The units of the header's columns, if the line is one of units.
    std::optional<std::vector<std::string>> units() const;
    // Takes the fields for the names of columns, if they can be.
    Refusal propose_header(std::size_t line);
    Refusal no_header_yet(std::string refusal);
    Refusal name_columns();
    // `units` go to the names that have none.
    Refusal settle_header(const std::vector<std::string>& units = {});
    Refusal find_wanted_columns(const std::vector<std::string>& names);
    Refusal read_fields(std::string_view line, const OnRow& on_row);
    // True: it is known of all wanted columns whether they hold text.
    bool decide_columns(bool at_last);
    void leave_out_ignored();
    Refusal read_undecided(const OnRow& on_row);
    Refusal read_row(const OnRow& on_row);
    Refusal read_time();
    template <class Number>
    Refusal parse(std::string_view field, Number& number);
    // NaN for a missing value, where rows may lack some.
    Refusal parse_value(std::size_t column);
    Refusal hand_over(std::size_t line, TimePoint time, std::span<const double> values, const OnRow& on_row);
    // The row that waited for the unit of time.
    Refusal hand_over_first(TimePoint time, const OnRow& on_row);
    void deliver(const TableRow& row, const OnRow& on_row);
    Refusal finish_rows(const OnRow& on_row);
    TableError error(std::string text) const { return {name_, line_, std::move(text)}; }

    std::string name_;
    TableOptions options_;
    TableFormat format_;
    std::vector<std::string> columns_;
    std::size_t fields_in_header_ = 0;  // 0: the header has not come
    std::optional<std::size_t> time_position_;
    std::optional<std::size_t> date_position_;
    std::vector<std::size_t> positions_;  // of the wanted columns, among the fields

    // A line that may be the header, before the next line has come.
    struct Header {
        std::size_t line;
        std::vector<std::string> names;
        std::optional<TimeColumn> time;
        bool has_values;  // as "Date; 22/11/2026" above a header has
    };
    std::optional<Header> header_;
    // The line with the most fields that is no header, and why.
    struct NoHeader {
        std::size_t line;
        std::size_t fields;
        std::string refusal;
    };
    std::optional<NoHeader> no_header_;
    std::size_t head_lines_ = 0;

    std::string start_;  // the first bytes
    std::optional<Utf16Text> utf16_;
    std::unique_ptr<csv_parser, FreeParser> parser_;
    std::string begun_;                     // the line whose end has not come yet
    std::string text_;                      // the fields of the current line, one after the other
    std::vector<std::string_view> fields_;  // into text_
    std::string number_;                    // a field with a point in place of its comma
    std::string date_and_time_;             // of two columns
    std::string comment_;                   // the last one before the first row
    std::size_t line_ = 1;
    std::size_t blank_line_ = 0;  // nothing but blank lines may follow
    std::size_t rows_ = 0;
    std::size_t handed_over_ = 0;
    bool has_separator_ = false;
    // The wanted columns that are not known to hold numbers, while there are any, and the lines since the
    // header.
    std::vector<std::size_t> undecided_;
    std::vector<bool> ignored_;  // of all wanted columns
    struct Line {
        std::size_t number;
        std::string text;
    };
    std::vector<Line> undecided_lines_;
    std::size_t undecided_bytes_ = 0;
    std::optional<TableClock> clock_;
    TimePoint time_{};
    std::vector<double> values_;
    RowCompleter completer_;
    struct First {
        std::size_t line;
        std::vector<double> values;
    };
    std::optional<First> first_;  // while the unit of time is not certain
    std::optional<TableError> error_;
};

}  // namespace afferent
