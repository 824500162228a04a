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

#include "afferent/io/files/table_error.hpp"
#include "afferent/io/files/table_format.hpp"
#include "afferent/runtime/time.hpp"

struct csv_parser;

namespace afferent {

// A row, valid during the call that hands it over. The values are those of the wanted columns, in their
// order.
struct TableRow {
    std::size_t line;
    TimePoint time;
    std::span<const double> values;
};

// A table is a header and at least one row; time rises from row to row, by any steps. How it is written is
// found out from its first lines (table_format.hpp). Every number in a wanted column is finite; other columns
// may hold anything. Lines that begin with # or % are comments. Every line ends in a newline: a last line
// without one may have lost digits and still look like a number, so it is left out (TableFormat).
class TableReader {
  public:
    using OnRow = std::function<void(const TableRow&)>;

    // Longer lines are refused, so that no input takes more memory than this. It is enough for a value from
    // each tactile afferent of a body.
    static constexpr std::size_t longest_line = std::size_t{4} << 20U;

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
    Refusal read_line(std::string_view line, const OnRow& on_row);
    bool is_comment(std::string_view line);
    Refusal split(std::string_view line);
    void split_at_spaces(std::string_view line);
    // The first line that is no comment is the header, unless all of it is numbers.
    Refusal read_first_line(std::string_view line, const OnRow& on_row);
    bool is_row_of_numbers();
    Refusal name_columns();
    Refusal read_header();
    Refusal read_row(const OnRow& on_row);
    Refusal read_time(std::string_view field);
    template <class Number>
    Refusal parse(std::string_view field, Number& number);
    void hand_over(std::size_t line, TimePoint time, std::span<const double> values, const OnRow& on_row);
    // The row that waited for the unit of time.
    void hand_over_first(TimePoint time, const OnRow& on_row);
    TableError error(std::string text) const { return {name_, line_, std::move(text)}; }

    std::string name_;
    TableOptions options_;
    TableFormat format_;
    std::vector<std::string> columns_;
    std::size_t fields_in_header_ = 0;  // 0: the header has not come
    std::optional<std::size_t> time_position_;
    std::vector<std::size_t> positions_;  // of the wanted columns, among the fields

    std::unique_ptr<csv_parser, FreeParser> parser_;
    std::string begun_;                     // the line whose end has not come yet
    std::string text_;                      // the fields of the current line, one after the other
    std::vector<std::string_view> fields_;  // into text_
    std::string number_;                    // a field with a point in place of its comma
    std::string comment_;                   // the last one before the first row
    std::size_t line_ = 1;
    std::size_t blank_line_ = 0;  // nothing but blank lines may follow
    std::size_t rows_ = 0;
    std::size_t handed_over_ = 0;
    bool has_separator_ = false;
    std::optional<TableClock> clock_;
    TimePoint time_{};
    std::vector<double> values_;
    struct First {
        std::size_t line;
        std::vector<double> values;
    };
    std::optional<First> first_;  // while the unit of time is not certain
    std::optional<TableError> error_;
};

}  // namespace afferent
