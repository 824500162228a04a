// The end of a link that connects.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "afferent/io/links/link.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// How long to try to reach a peer that does not answer. The pauses between attempts double up to the longest.
struct Patience {
    std::chrono::milliseconds first_pause{20};
    std::chrono::milliseconds longest_pause{1000};
    std::chrono::milliseconds limit{10'000};
};

// Connects to a listener, or reports why it cannot: `unreachable` with the system's last reason when patience
// ends, `not_allowed` at once.
class Connector {
  public:
    // Cancels the attempt that is under way, without a callback.
    virtual ~Connector() = default;

    // Calls back once, from the I/O loop. May be called again after that.
    virtual void start(std::function<void(Result<std::unique_ptr<Link>>)> on_link) = 0;
};

}  // namespace afferent
