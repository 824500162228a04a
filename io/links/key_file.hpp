// Reads files of keys and certificates.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "afferent/runtime/result.hpp"

namespace afferent {

enum class KeyFile {
    secret,  // only its owner may read it
    open,    // everybody may
};

// Reads as much as there is room for, and returns how many bytes. `not_allowed` if it is not a regular file,
// cannot be read, or is a secret that others may read; the text says what to do.
Result<std::size_t> read_key_file(const std::filesystem::path& file, KeyFile kind, std::span<char> into);

}  // namespace afferent
