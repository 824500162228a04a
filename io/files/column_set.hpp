// Columns of numbers out of a file of datasets, which an HDF5 or NPZ file is, as they come through a pipe
// from the program that reads it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "afferent/io/files/table.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

struct ColumnSet {
    std::vector<std::string> names;
    std::string time;  // the name of the column that is time; empty: none is
    std::size_t rows = 0;
    std::vector<double> values;  // column by column
};

std::vector<std::byte> to_bytes(const ColumnSet& set);
// Checked: the bytes may come from a program that has read a hostile file.
Result<ColumnSet> column_set(std::span<const std::byte> bytes);

// A dataset of one dimension, or of two, rows and columns. Its name may be a path: "run/force_n".
struct NumberArray {
    std::string name;
    std::uint64_t rows;
    std::uint64_t columns;
    std::function<Result<std::vector<double>>()> read;  // row by row
};

// Time, and the wanted datasets, or all that are as long as time. The columns of one of two dimensions are
// called after it: those of force_n are force_1_n, force_2_n, and so on.
Result<ColumnSet> columns_of(const std::vector<NumberArray>& arrays, const TableOptions& options);

// By the rules of TableReader for times.
std::variant<Table, TableError> table_of(const ColumnSet& set, const std::string& file,
                                         const TableOptions& options);

}  // namespace afferent
