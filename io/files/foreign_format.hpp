// Says what to do with files that are tables, and are not read.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace afferent {

// By the first bytes of a file, of which eight are enough. Nothing: they are of none of these.
std::optional<std::string> foreign_format(std::string_view first_bytes);

}  // namespace afferent
