// Recorded scans in HDF5.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "afferent/runtime/result.hpp"

namespace afferent {

// Reads a dataset of scans and elements, or of scans, rows and columns, which may lie in groups
// ("run/force_n"). The scans' times are a dataset time_s in the same group, or follow from an attribute
// rate_hz of the dataset. Hands over the bytes of a ScanSet, a scan at a time.
Result<void> read_scans(const std::filesystem::path& file, const std::string& dataset,
                        const std::function<void(std::span<const std::byte>)>& say);

}  // namespace afferent
