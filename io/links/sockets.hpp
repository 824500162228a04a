// Links over Unix sockets and TCP.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

// `not_allowed`, or why the system would not. A Unix socket that nobody listens to any more is replaced. A
// second peer is refused in words. What leaves the machine has to be authenticated, so that TCP is open to
// the machine itself only.
Result<std::unique_ptr<Listener>> open_socket_listener(boost::asio::io_context& io,
                                                       const UnixAddress& address,
                                                       const LinkOptions& options);
Result<std::unique_ptr<Listener>> open_socket_listener(boost::asio::io_context& io, const TcpAddress& address,
                                                       const LinkOptions& options);

std::unique_ptr<Connector> make_socket_connector(boost::asio::io_context& io, const UnixAddress& address,
                                                 const Patience& patience, const LinkOptions& options);
std::unique_ptr<Connector> make_socket_connector(boost::asio::io_context& io, const TcpAddress& address,
                                                 const Patience& patience, const LinkOptions& options);

}  // namespace afferent
