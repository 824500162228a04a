// Certificates and keys in OpenSSL's hands. For the transports; programs use transports.hpp.
#pragma once

#include <openssl/types.h>

#include "afferent/io/links/tls.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

// Our certificate and key, and the one certificate that a peer must show. Its dates are ignored: a hand may
// have no clock with the date, and a pair ends when its files are removed. The key's bytes stay in memory
// that is left out of core dumps. `not_allowed` as listen_on() says.
Result<void> load_credentials(SSL_CTX* context, const TlsCredentials& credentials);

}  // namespace afferent
