// What becomes of the rows of a table that lack values.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/io/files/time_unit.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// A row, valid during the call that hands it over. The values are those of the wanted columns, in their
// order.
struct TableRow {
    std::size_t line;
    TimePoint time;
    std::span<const double> values;
};

// How many values were missing, and where the first was.
struct MissingValues {
    Missing rule = Missing::refuse;
    std::size_t values = 0;
    std::size_t rows = 0;
    std::size_t first_line = 0;
    std::string first_column = {};

    void count(std::size_t line, std::string_view column);
    // "3 values are missing in 2 rows, the first of column "f" in line 12"
    std::string text(std::string_view line = "line") const;
};

// An empty field, NaN, NA, N/A, null, none, and any number of "-": loggers write these where a sensor gave
// no value.
bool stands_for_nothing(std::string_view field) noexcept;

// Skips rows in which a value is missing (NaN), or draws a straight line from the value before to the one
// behind; before the first value of a column and after its last these are held.
class RowCompleter {
  public:
    using OnRow = std::function<void(const TableRow&)>;
    // So many values wait at most for one that is not missing.
    static constexpr std::size_t most_waiting = std::size_t{1} << 20U;

    explicit RowCompleter(Missing rule) noexcept : rule_(rule) {}

    // Each says why the rows cannot be completed, if they cannot.
    std::optional<std::string> take(const TableRow& row, const OnRow& on_row);
    std::optional<std::string> finish(const OnRow& on_row);

  private:
    struct Waiting {
        std::size_t line;
        TimePoint time;
        std::vector<double> values;
    };
    struct Column {
        std::optional<double> value;  // its last
        TimePoint time{};
        std::size_t gap = 0;  // the rows since then, which wait
    };

    void fill(std::size_t column, TimePoint time, double value);

    Missing rule_;
    std::vector<Column> columns_;
    std::deque<Waiting> waiting_;  // the front one is incomplete
};

}  // namespace afferent
