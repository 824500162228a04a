// Links over every transport, by address.
#pragma once

#include <memory>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/link_address.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

// Errors: `not_allowed`, with what to do instead, or the system's reason.
Result<std::unique_ptr<Listener>> open_listener(boost::asio::io_context& io, const LinkAddress& address,
                                                const LinkOptions& options = {});

std::unique_ptr<Connector> make_connector(boost::asio::io_context& io, const LinkAddress& address,
                                          const Patience& patience = {}, const LinkOptions& options = {});

}  // namespace afferent
