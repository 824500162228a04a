// Links over Unix sockets and TCP: one side listens, the other connects.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "afferent/io/link.hpp"
#include "afferent/io/result.hpp"

namespace afferent {

struct UnixAddress {
    std::string path;
};

// Port 0: any free one, for listening.
struct TcpAddress {
    std::string host;
    std::uint16_t port;
};

using SocketAddress = std::variant<UnixAddress, TcpAddress>;

// "unix:/run/hand.sock", "tcp:127.0.0.1:7450"
std::string text(const SocketAddress& address);

// Opens the address and hands over one peer at a time: while its link lives, a further one is refused, in
// words. What leaves the machine has to be authenticated, so that TCP is open to the machine itself only.
class Listener {
  public:
    // `not_allowed`, or why the system would not. A Unix socket that nobody listens to any more is replaced.
    static Result<std::unique_ptr<Listener>> open(boost::asio::io_context& io, const SocketAddress& address,
                                                  const LinkOptions& options = {});
    virtual ~Listener() = default;

    // Calls back for each peer, until the listener is destroyed.
    virtual void start(std::function<void(std::unique_ptr<Link>)> on_peer) = 0;

    // With the port that was found for port 0.
    virtual SocketAddress address() const = 0;
    virtual std::uint64_t refused_peers() const = 0;
};

// How long to try to reach an absent peer: pauses double from the first to the longest.
struct Patience {
    std::chrono::milliseconds first_pause{20};
    std::chrono::milliseconds longest_pause{1000};
    std::chrono::milliseconds limit{10'000};
};

// Reaches a listener, or says why not: `unreachable` once patience has ended, with the last reason of the
// system, `not_allowed` at once.
class Connector {
  public:
    static std::unique_ptr<Connector> create(boost::asio::io_context& io, const SocketAddress& address,
                                             const Patience& patience = {}, const LinkOptions& options = {});
    // Calls off the attempt that is under way, without a callback.
    virtual ~Connector() = default;

    // Calls back once, from the I/O loop. May be called again after that.
    virtual void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) = 0;
};

}  // namespace afferent
