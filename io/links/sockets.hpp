// Links over Unix sockets and TCP.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

class Connector;
class Listener;
struct LinkOptions;
struct Patience;

struct UnixAddress {
    std::string path;

    std::string text() const;
};

// Port 0: any free one, for listening.
struct TcpAddress {
    std::string host;
    std::uint16_t port;

    std::string text() const;
};

// Errors: `not_allowed`, or the system's reason. The file of a Unix socket without a listener is replaced.
// Plain TCP is limited to this machine: beyond it a link has to be authenticated.
Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const UnixAddress& address,
                                            const LinkOptions& options);
Result<std::unique_ptr<Listener>> listen_on(boost::asio::io_context& io, const TcpAddress& address,
                                            const LinkOptions& options);

std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const UnixAddress& address,
                                        const Patience& patience, const LinkOptions& options);
std::unique_ptr<Connector> connector_to(boost::asio::io_context& io, const TcpAddress& address,
                                        const Patience& patience, const LinkOptions& options);

}  // namespace afferent
