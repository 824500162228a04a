// Links over sockets that carry streams, plain or secured. For the transports; programs use transports.hpp.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "afferent/io/links/acceptor.hpp"
#include "afferent/io/links/stream_transport.hpp"

namespace afferent {

enum class StreamRole { listens, connects };

// Calls off an operation; empty where there is nothing to call off.
using CallOff = std::shared_ptr<std::function<void()>>;

// Makes a connection of a socket: at once if it is plain, for TLS after a handshake, which sets `call_off`.
// It calls `done` in either case, if need be with an error.
using Secure = std::function<void(StreamSocket socket, StreamRole role, const CallOff& call_off,
                                  const OnStreamPeer& done)>;

std::shared_ptr<StreamPeer> plain_connection(StreamSocket socket, const LinkOptions& options);

Result<std::unique_ptr<Listener>> open_socket_listener(boost::asio::io_context& io,
                                                       const LinkAddress& address,
                                                       const StreamEndpoint& endpoint, Secure secure,
                                                       const LinkOptions& options);

// `limit` is the time for the connection and for securing it.
std::unique_ptr<ConnectionAttempt> make_socket_attempt(
    boost::asio::io_context& io, const StreamEndpoint& endpoint, Secure secure, const LinkOptions& options,
    std::chrono::milliseconds limit = std::chrono::milliseconds(2000));

// Sets small buffers, no delay, and a limit on how long the peer may leave bytes unacknowledged, where the
// socket's family has these options.
void tune(StreamSocket& socket, const LinkOptions& options);

}  // namespace afferent
