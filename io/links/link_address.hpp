// Where the two ends of a link meet, and what they prove themselves with.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "afferent/io/links/secret_key.hpp"

namespace afferent {

struct UnixAddress {
    std::string path;
};

// Port 0: any free one, for listening.
struct TcpAddress {
    std::string host;
    std::uint16_t port;
};

// PEM files: what we show, how we prove that it is ours, and the one certificate that we accept.
struct TlsCredentials {
    std::filesystem::path certificate;
    std::filesystem::path private_key;
    std::filesystem::path peer_certificate;
};

struct TlsAddress {
    std::string host;
    std::uint16_t port;
    TlsCredentials credentials;
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

using LinkAddress = std::variant<UnixAddress, TcpAddress, TlsAddress, UdpAddress, SerialAddress>;

// "unix:/run/hand.sock", "tcp:127.0.0.1:7450", "tls:192.0.2.7:7450", "udp:127.0.0.1:7450",
// "serial:/dev/ttyUSB0". Never the key.
std::string text(const LinkAddress& address);

}  // namespace afferent
