// Links over TLS 1.3, each end known to the other by its certificate.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

// `not_allowed` where a file of the credentials cannot be read or does not fit the others, or a private key
// is open to others than its owner. A peer whose certificate is another than the one that we hold is turned
// away, and counted; so is one that speaks an older version, or none.
Result<std::unique_ptr<Listener>> open_tls_listener(boost::asio::io_context& io, const TlsAddress& address,
                                                    const LinkOptions& options);

std::unique_ptr<Connector> make_tls_connector(boost::asio::io_context& io, const TlsAddress& address,
                                              const Patience& patience, const LinkOptions& options);

}  // namespace afferent
