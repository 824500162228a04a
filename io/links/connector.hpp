// The end of a link that looks for a peer.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "afferent/io/links/link.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

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
    // Calls off the attempt that is under way, without a callback.
    virtual ~Connector() = default;

    // Calls back once, from the I/O loop. May be called again after that.
    virtual void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) = 0;
};

}  // namespace afferent
