// The list of transports: where the two ends of a link meet, and their credentials.
#pragma once

#include <string>
#include <variant>

#include "afferent/io/links/datagram_transports.hpp"
#include "afferent/io/links/sockets.hpp"
#include "afferent/io/links/tls.hpp"

namespace afferent {

// A transport is an address with a text(), and two functions over it: listen_on() and connector_to().
using LinkAddress = std::variant<UnixAddress, TcpAddress, TlsAddress, UdpAddress, SerialAddress>;

// "unix:/run/hand.sock", "tcp:127.0.0.1:7450", "tls:192.0.2.7:7450", "udp:127.0.0.1:7450",
// "serial:/dev/ttyUSB0". Never the key.
inline std::string text(const LinkAddress& address) {
    return std::visit([](const auto& one) { return one.text(); }, address);
}

}  // namespace afferent
