// MATLAB's files, of version 5 (save) and 7.3 (save -v7.3).
#pragma once

#include <filesystem>

#include "afferent/io/files/column_text.hpp"

namespace afferent {

// Variables of real numbers, and those in the fields of a structure, which is a group. A variable of N x 1 or
// 1 x N is a column. All of them are held in memory, and may have 256 MB of numbers.
Result<void> send_mat(const std::filesystem::path& file, const TableOptions& options, const SendPiece& send);

}  // namespace afferent
