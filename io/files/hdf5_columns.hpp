// A table out of the datasets of an HDF5 file.
#pragma once

#include <filesystem>

#include "afferent/io/files/column_text.hpp"

namespace afferent {

// Sends the columns of the group that has the first wanted column, or else the column of time; otherwise of
// the file's root.
Result<void> send_hdf5_columns(const std::filesystem::path& file, const TableOptions& options,
                               const SendPiece& send);

// Whether a dataset is scans as io/files/scan_file.hpp has them: images, or values for elements whose times
// or rate are beside it by their own names. Anything else is read as columns.
bool has_scans(const std::filesystem::path& file, const std::string& dataset);

}  // namespace afferent
