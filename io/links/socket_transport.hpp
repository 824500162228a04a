// Links over sockets that carry streams, plain or secured. For the transports; programs use transports.hpp.
#pragma once

#include <functional>
#include <memory>

#include "afferent/io/links/acceptor.hpp"
#include "afferent/io/links/stream_transport.hpp"

namespace afferent {

enum class StreamRole { listens, connects };

// What ends something early; it is empty where there is nothing to end.
using CallOff = std::shared_ptr<std::function<void()>>;

// Makes a connection of a socket: of a plain one at once, for TLS after a handshake, which sets what ends it
// early. It is done in either case, with an error then.
using Secure = std::function<void(StreamSocket socket, StreamRole role, const CallOff& call_off,
                                  const OnStreamPeer& done)>;

std::shared_ptr<StreamPeer> plain_connection(StreamSocket socket, const LinkOptions& options);

Result<std::unique_ptr<Listener>> open_socket_listener(boost::asio::io_context& io,
                                                       const LinkAddress& address,
                                                       const StreamEndpoint& endpoint, Secure secure,
                                                       const LinkOptions& options);

std::unique_ptr<ConnectionAttempt> make_socket_attempt(boost::asio::io_context& io,
                                                       const StreamEndpoint& endpoint, Secure secure,
                                                       const LinkOptions& options);

// Small buffers, no delay, a limit on how long the peer may leave bytes unacknowledged: as far as the
// socket's family has them.
void tune(StreamSocket& socket, const LinkOptions& options);

}  // namespace afferent
