// Reads a CSV table as its bytes arrive, so that the same code reads a file and standard input.
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

// A table is a header and at least one row; a column `time_s` rises from row to row, by any steps, from 0 on.
// Every number in a wanted column is finite; other columns may hold anything. Every line ends in a newline: a
// last line without one may have lost digits and still look like a number, so it is refused.
class TableReader {
  public:
    using OnRow = std::function<void(const TableRow&)>;

    // Longer lines are refused, so that no input takes more memory than this. It is enough for a value from
    // each tactile afferent of a body.
    static constexpr std::size_t longest_line = std::size_t{4} << 20U;

    // The name begins every message. No wanted columns: all but time_s.
    explicit TableReader(std::string name, std::vector<std::string> wanted = {});

    // Hands over the rows that end in these bytes. After the first error nothing more is read, and every call
    // returns that error.
    [[nodiscard]] std::optional<TableError> feed(std::string_view bytes, const OnRow& on_row);
    // The input has ended.
    [[nodiscard]] std::optional<TableError> finish();

    // The names of the values of a row. Empty before the header has been read.
    const std::vector<std::string>& columns() const noexcept { return columns_; }
    const std::string& name() const noexcept { return name_; }

  private:
    struct FreeParser {
        void operator()(csv_parser* parser) const noexcept;
    };
    // Says what is wrong with the current line, if anything is.
    using Refusal = std::optional<std::string>;

    Refusal take(std::string_view bytes, const OnRow& on_row);
    Refusal read_line(std::string_view line, const OnRow& on_row);
    Refusal split(std::string_view line);
    Refusal read_header();
    Refusal read_row(const OnRow& on_row);
    Refusal read_time(std::string_view field);
    TableError error(std::string text) const { return {name_, line_, std::move(text)}; }

    std::string name_;
    std::vector<std::string> wanted_;
    std::vector<std::string> columns_;
    std::size_t fields_in_header_ = 0;
    std::size_t time_position_ = 0;
    std::vector<std::size_t> positions_;  // of the wanted columns, among the fields

    std::unique_ptr<csv_parser, FreeParser> parser_;
    std::string begun_;                     // the line whose end has not come yet
    std::string text_;                      // the fields of the current line, one after the other
    std::vector<std::string_view> fields_;  // into text_
    std::size_t line_ = 1;
    std::size_t rows_ = 0;
    TimePoint time_{};
    std::vector<double> values_;
    std::optional<TableError> error_;
};

}  // namespace afferent
