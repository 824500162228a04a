// The certificate that one end of a TLS link shows, and the key that goes with it.
#pragma once

#include <filesystem>
#include <string>

#include "afferent/runtime/result.hpp"

namespace afferent {

// Makes a key (ECDSA, P-256: what both TLS 1.3 and OpenSSL's DTLS 1.2 take) and a self-signed certificate,
// and writes both as PEM; only the owner may read the key's file. Existing files are not overwritten.
Result<void> write_certificate(const std::string& name, const std::filesystem::path& certificate,
                               const std::filesystem::path& private_key);

}  // namespace afferent
