// Columns of numbers out of a file of datasets, which an HDF5, NPZ or MAT file is, as text for a TableReader.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/files/table.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// A dataset of one dimension, or of two, rows and columns. Its name may be a path: "run/force_n".
struct NumberArray {
    std::string name;
    std::uint64_t rows;
    std::uint64_t columns;
    // Fills in these rows, column after column of each. They follow those of the call before.
    std::function<Result<void>(std::uint64_t first_row, std::span<double> values)> read;
};

// An array has so many numbers at most.
inline constexpr std::uint64_t most_numbers = std::uint64_t{1} << 36U;

// The program sends a head, then text. The byte `why_no_more` within the text begins the reason why no more
// rows follow.
struct ColumnTextHead {
    static constexpr std::uint64_t this_format = 0x3174'7865'746c'6f63;  // "coltext1"
    std::uint64_t format = this_format;
    std::uint64_t rows = 0;
};
inline constexpr char why_no_more = '\x18';

// Time, and the wanted datasets, or all that are as long as time, in pieces of bounded size. The columns of
// one of two dimensions are called after it: those of force_n are force_1_n, force_2_n, and so on. A dataset
// of a single row is one column. An error: nothing was sent.
using SendPiece = std::function<void(std::span<const std::byte>)>;
Result<void> send_columns(std::vector<NumberArray> arrays, const TableOptions& options,
                          const SendPiece& send);

// A group of datasets of numbers, as a folder is of files.
struct DatasetGroup {
    std::string path;  // "" is the root, and others end in a slash
    std::vector<std::string> names;
};

// The group that the options ask for.
std::string asked_group(const TableOptions& options);
// The group whose datasets are the table: the one asked for, or the only one that has any. An error names the
// others.
Result<std::string> group_of_table(const std::string& asked, const std::vector<DatasetGroup>& groups);

// How a TableReader is to read that text, of which these were the options.
TableOptions options_of_column_text(TableOptions options);

}  // namespace afferent
