// Where the two ends of a link meet, and what they prove themselves with.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "afferent/io/secret_key.hpp"

namespace afferent {

struct UnixAddress {
    std::string path;
};

// Port 0: any free one, for listening.
struct TcpAddress {
    std::string host;
    std::uint16_t port;
};

// Sealed with the key. Without one it does not leave the machine.
struct UdpAddress {
    std::string host;
    std::uint16_t port;
    std::optional<SecretKey> key;
};

// Any tty. Who is at the other end of a wire cannot be known without a key.
struct SerialAddress {
    std::string device;
    std::uint32_t baud;
    SecretKey key;
};

using LinkAddress = std::variant<UnixAddress, TcpAddress, UdpAddress, SerialAddress>;

// "unix:/run/hand.sock", "tcp:127.0.0.1:7450", "udp:127.0.0.1:7450", "serial:/dev/ttyUSB0". Never the key.
std::string text(const LinkAddress& address);

}  // namespace afferent
