// The end of a datagram link that accepts peers. For the transports; programs use transports.hpp.
#pragma once

#include <memory>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/dtls.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

// Accepts the first peer that says hello, on a sealed link after a handshake; without a context the link is
// plain. While a peer is alive, others are turned away and told so; one that has been silent for
// LinkOptions::alive_limit makes way. A port that fails is opened again.
std::unique_ptr<Listener> make_datagram_listener(boost::asio::io_context& io, const LinkAddress& address,
                                                 std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
                                                 DtlsContext keys, const LinkOptions& options);

}  // namespace afferent
