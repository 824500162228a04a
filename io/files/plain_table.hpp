// Reads numbers from a CSV table that has no time.
#pragma once

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "afferent/io/files/table_error.hpp"

namespace afferent {

// The values of the wanted columns, row by row. The first line names the columns, of which there may be
// others; numbers are finite, and nothing is quoted. A file of more than 16 MB, or one that is no regular
// file, is refused.
[[nodiscard]] std::variant<std::vector<double>, TableError> read_plain_table(
    const std::filesystem::path& file, const std::vector<std::string>& wanted);

}  // namespace afferent
