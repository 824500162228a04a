// Links over UDP and the serial line.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/tls.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

class Connector;
class Listener;
struct LinkOptions;
struct Patience;

// Sealed if there are credentials. Without them the link may not leave the machine.
struct UdpAddress {
    std::string host;
    std::uint16_t port;
    std::optional<TlsCredentials> credentials;

    std::string text() const;
};

// Any tty. The credentials are required: nothing else tells what is at the other end of a wire.
struct SerialAddress {
    std::string device;
    std::uint32_t baud;
    TlsCredentials credentials;

    std::string text() const;
};

Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const UdpAddress& address,
                                            const LinkOptions& options);
Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const SerialAddress& address,
                                            const LinkOptions& options);

std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const UdpAddress& address,
                                        const Patience& patience, const LinkOptions& options);
std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const SerialAddress& address,
                                        const Patience& patience, const LinkOptions& options);

}  // namespace afferent
