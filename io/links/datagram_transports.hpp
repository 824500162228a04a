// Links over UDP and the serial line.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

Result<std::unique_ptr<Listener>> open_datagram_listener(boost::asio::io_context& io,
                                                         const UdpAddress& address,
                                                         const LinkOptions& options);
Result<std::unique_ptr<Listener>> open_datagram_listener(boost::asio::io_context& io,
                                                         const SerialAddress& address,
                                                         const LinkOptions& options);

std::unique_ptr<Connector> make_datagram_connector(boost::asio::io_context& io, const UdpAddress& address,
                                                   const Patience& patience, const LinkOptions& options);
std::unique_ptr<Connector> make_datagram_connector(boost::asio::io_context& io, const SerialAddress& address,
                                                   const Patience& patience, const LinkOptions& options);

}  // namespace afferent
