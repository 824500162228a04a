// NumPy's files: an array in NPY, several of them zipped in NPZ.
#pragma once

#include <filesystem>

#include "afferent/io/files/column_text.hpp"

namespace afferent {

// Arrays of numbers (integers, floating point, truth values, dates) of one or two dimensions. Objects, which
// would run Python's code to be read, and structures are refused where they are wanted, and otherwise passed
// over.
Result<void> send_npz(const std::filesystem::path& file, const TableOptions& options, const SendPiece& send);
Result<void> send_npy(const std::filesystem::path& file, const TableOptions& options, const SendPiece& send);

}  // namespace afferent
