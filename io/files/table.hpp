// A whole table in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "afferent/io/files/table_error.hpp"
#include "afferent/io/files/table_format.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// When a table begins and ends, without its values.
struct TableSpan {
    TimePoint first{};
    TimePoint last{};
    std::size_t rows = 0;
    TableFormat format = {};

    // From time 0 to the end of the last row, which is as long as the rows are on average.
    Duration length() const noexcept;
};

struct Table {
    // Values and times that a table has at most: 256 MiB of them.
    static constexpr std::size_t most_values = std::size_t{1} << 25U;

    std::string file;
    std::vector<std::string> columns;  // without that of time
    std::vector<TimePoint> times;
    std::vector<double> values;  // row by row
    TableFormat format = {};

    std::size_t rows() const noexcept { return times.size(); }
    std::span<const double> row(std::size_t i) const noexcept {
        return std::span(values).subspan(i * columns.size(), columns.size());
    }
    TableSpan span() const;
};

struct TableLimits {
    // A longer table is refused, or only its first rows are read.
    std::size_t most_values = Table::most_values;
    bool cuts = false;
    // Called now and then with the part that is read.
    std::function<void(double fraction)> progress = {};
};

// A table of text, which gzip may have compressed, by the rules of TableReader; or datasets in HDF5 (*.h5,
// *.hdf5), NPZ or NPY, which the program afferent-hdf5 reads (hdf5_process.hpp).
//
//     auto read = read_table("forces.csv", {.time_column = "t", .time_unit = TimeUnit::milliseconds});
[[nodiscard]] std::variant<Table, TableError> read_table(const std::filesystem::path& file,
                                                         TableOptions options = {},
                                                         const TableLimits& limits = {});

// The same of a file of any length, which is read through for that.
[[nodiscard]] std::variant<TableSpan, TableError> read_span(
    const std::filesystem::path& file, TableOptions options = {},
    const std::function<void(double fraction)>& progress = {});

// By the ending of its name: it is not read as text.
bool is_container(const std::filesystem::path& file);

}  // namespace afferent
