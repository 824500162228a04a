// Listeners and connectors of links over streams, whatever the streams are. For the transports; programs use
// transports.hpp.
#pragma once

#include <memory>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"
#include "afferent/io/links/stream_peer.hpp"

namespace afferent {

// Accepts one peer after another. Its destructor ends that, without another callback.
class ConnectionAcceptor {
  public:
    virtual ~ConnectionAcceptor() = default;

    // Calls back from the I/O loop, for each peer: its connection, from which nothing has been read, or why
    // it was turned away. To be called once.
    virtual void start(OnStreamPeer on_peer) = 0;
};

// Tries to reach a peer. Its destructor calls off the attempt that is under way.
class ConnectionAttempt {
  public:
    virtual ~ConnectionAttempt() = default;

    // Calls back once from the I/O loop; `not_allowed` where no later attempt could fare better. May be
    // called again after that.
    virtual void start(OnStreamPeer on_peer) = 0;
    // No callback any more.
    virtual void call_off() = 0;
};

// Accepts one peer at a time: the first whose hello has arrived. Until then peers wait in a bounded line.
// While the peer is alive, others are refused with a reason; if nothing has been heard of it for
// `options.alive_limit`, it makes way.
std::unique_ptr<Listener> make_stream_listener(boost::asio::io_context& io, const LinkAddress& address,
                                               std::unique_ptr<ConnectionAcceptor> acceptor,
                                               const LinkOptions& options);

// If there is an error in place of an attempt, every start reports it.
std::unique_ptr<Connector> make_stream_connector(boost::asio::io_context& io, const LinkAddress& address,
                                                 Result<std::unique_ptr<ConnectionAttempt>> attempt,
                                                 const Patience& patience);

}  // namespace afferent
