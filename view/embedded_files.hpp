// The files of the page, which the build puts into the program.
#pragma once

#include <span>
#include <string_view>

namespace afferent {

struct EmbeddedFile {
    std::string_view name;
    std::string_view content;
};

std::span<const EmbeddedFile> embedded_files() noexcept;

}  // namespace afferent
