// Reads the files that keys and certificates are in.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "afferent/io/wire/result.hpp"

namespace afferent {

enum class KeyFile {
    secret,  // its owner's alone
    open,    // for everybody to read
};

// As much of the file as there is room for; how many bytes that are. `not_allowed` where it is no regular
// file, cannot be read, or is a secret that others may read, with what to do about that.
Result<std::size_t> read_key_file(const std::filesystem::path& file, KeyFile kind, std::span<char> into);

}  // namespace afferent
