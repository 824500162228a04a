// The end of a link that waits for a peer.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "afferent/io/links/link.hpp"
#include "afferent/io/links/link_address.hpp"

namespace afferent {

// Hands over one peer at a time.
class Listener {
  public:
    virtual ~Listener() = default;

    // Calls back for each peer, until the listener is destroyed. Links live on without it.
    virtual void start(std::function<void(std::unique_ptr<Link>)> on_peer) = 0;

    // With the port that was found for port 0.
    virtual LinkAddress address() const = 0;
    // While a peer's link lives, others are turned away.
    virtual std::uint64_t refused_peers() const = 0;
    // Datagrams that belonged to no link and were no request. They had no other effect than this count.
    virtual std::uint64_t strays() const { return 0; }
};

}  // namespace afferent
