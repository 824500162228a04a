// What the two ends of a link prove themselves with.
#pragma once

#include <filesystem>

#include "afferent/runtime/result.hpp"

struct ssl_ctx_st;

namespace afferent {

// PEM files: our certificate, its private key, and the one certificate that we accept.
struct TlsCredentials {
    std::filesystem::path certificate;
    std::filesystem::path private_key;
    std::filesystem::path peer_certificate;
};

// Both ends show their certificate, and accept the one that they hold of the other and nothing else. No
// authority is asked and dates are ignored: a hand may have no clock with the date, and a pair ends when its
// files are removed. No session is resumed. `not_allowed` if a file cannot be read or does not fit the
// others, or if others than its owner may read the private key.
Result<void> use_credentials(::ssl_ctx_st* context, const TlsCredentials& credentials);

}  // namespace afferent
