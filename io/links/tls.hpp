// Links over TLS 1.3. Each end knows the other by its certificate.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/credentials.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

class Connector;
class Listener;
struct LinkOptions;
struct Patience;

struct TlsAddress {
    std::string host;
    std::uint16_t port;
    TlsCredentials credentials;

    std::string text() const;
};

// Errors of the credentials are those of use_credentials(). A peer with another certificate than the one we
// hold is refused and counted, as is one with an older version of TLS, or without TLS.
Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const TlsAddress& address,
                                            const LinkOptions& options);

std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const TlsAddress& address,
                                        const Patience& patience, const LinkOptions& options);

}  // namespace afferent
