// The files of the page, which the build puts into the program.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace afferent {

// Name and content.
std::span<const std::pair<std::string_view, std::string_view>> embedded_files() noexcept;

}  // namespace afferent
