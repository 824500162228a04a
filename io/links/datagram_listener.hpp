// The end of a datagram link that waits for a peer. For the transports; programs use transports.hpp.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "afferent/io/links/asio_forward.hpp"
#include "afferent/io/links/datagram_port.hpp"
#include "afferent/io/links/listener.hpp"

namespace afferent {

// A plain one believes an address: while its link lives, others are turned away, in words once they have
// asked for longer than a peer may be silent. A sealed one believes a key: whoever has it and begins anew is
// the same peer, and its old link ends. A port that fails is opened again.
std::unique_ptr<Listener> make_datagram_listener(boost::asio::io_context& io, const LinkAddress& address,
                                                 std::shared_ptr<DatagramPort> port, OpenDatagramPort reopen,
                                                 const std::optional<SecretKey>& key,
                                                 const LinkOptions& options);

}  // namespace afferent
