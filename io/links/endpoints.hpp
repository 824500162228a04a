// From addresses to Asio's endpoints, if the address is allowed. For the transports; programs use
// transports.hpp.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cstdint>
#include <string>

#include "afferent/io/links/link_address.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// `not_allowed` if a path is too long, a host is a name (names are not looked up), or an address without keys
// leaves the machine.
Result<boost::asio::local::stream_protocol::endpoint> endpoint_of(const UnixAddress& address);
Result<boost::asio::ip::tcp::endpoint> endpoint_of(const TcpAddress& address);
Result<boost::asio::ip::tcp::endpoint> endpoint_of(const TlsAddress& address);
Result<boost::asio::ip::udp::endpoint> endpoint_of(const UdpAddress& address);

// "127.0.0.1:7450", "[::1]:7450".
std::string host_and_port(const std::string& host, std::uint16_t port);

// The system's message, after the address.
Error system_error(Error::Kind kind, const LinkAddress& address, const boost::system::error_code& error);

}  // namespace afferent
