// Datagrams over UDP.
#pragma once

#include <boost/asio/ip/udp.hpp>
#include <memory>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/datagram_port.hpp"

namespace afferent {

// Bound to this endpoint, whose port 0 becomes the one that was found.
Result<std::shared_ptr<DatagramPort>> open_udp_port(boost::asio::io_context& io,
                                                    boost::asio::ip::udp::endpoint& endpoint,
                                                    const LinkOptions& options);
// Exchanges datagrams with this peer and no other.
Result<std::shared_ptr<DatagramPort>> open_udp_port_to(boost::asio::io_context& io,
                                                       const boost::asio::ip::udp::endpoint& peer,
                                                       const LinkOptions& options);

}  // namespace afferent
