// The end of a link that accepts peers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "afferent/io/links/link.hpp"
#include "afferent/io/links/link_address.hpp"

namespace afferent {

// Has one peer at a time.
class Listener {
  public:
    virtual ~Listener() = default;

    // Calls back for each peer, until the listener is destroyed. Links live on without it.
    virtual void start(std::function<void(std::unique_ptr<Link>)> on_peer) = 0;

    // The address in use: with the port that the system chose in place of port 0.
    virtual LinkAddress address() const = 0;
    // How many peers were turned away, because another was connected or because they were not the right one.
    virtual std::uint64_t refused_peers() const = 0;
    // Datagrams that belonged to no link and were no request. They had no other effect than this count.
    virtual std::uint64_t strays() const { return 0; }
};

}  // namespace afferent
