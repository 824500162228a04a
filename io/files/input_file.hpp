// A file to be read.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>

#include "afferent/runtime/result.hpp"

namespace afferent {

struct CloseInput {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};
using InputFile = std::unique_ptr<std::FILE, CloseInput>;

// `unreachable`, with the file's name and what to do, if it cannot be read. A folder is refused here, because
// opening it would succeed and only reading it fail.
Result<InputFile> open_input(const std::filesystem::path& file);

}  // namespace afferent
