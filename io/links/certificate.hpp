// The certificate that one end of a TLS link shows, and the key that goes with it.
#pragma once

#include <filesystem>
#include <string>

#include "afferent/io/wire/result.hpp"

namespace afferent {

// Makes an Ed25519 key and a certificate that it signs itself, and writes both as PEM; the key's file is its
// owner's alone. Files that are there are not written over.
Result<void> write_certificate(const std::string& name, const std::filesystem::path& certificate,
                               const std::filesystem::path& private_key);

}  // namespace afferent
