// The end of a datagram link that accepts peers. For the transports; programs use transports.hpp.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

// A plain listener knows its peer by the address: while the link lives, others are turned away, and are told
// so once they have tried for longer than a peer may be silent. A sealed one knows its peer by the key: a new
// handshake with it is the same peer again, and ends the old link. A port that fails is opened again.
std::unique_ptr<Listener> make_datagram_listener(boost::asio::io_context& io, const LinkAddress& address,
                                                 std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
                                                 const std::optional<SecretKey>& key,
                                                 const LinkOptions& options);

}  // namespace afferent
