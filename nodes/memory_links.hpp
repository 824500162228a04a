// Links between nodes of one program, on a clock of its own: what one end sends is handed to the other, with
// no system in between. For nodes that live together, and for tests in virtual time.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/listener.hpp"
#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {

// One listener and any number of connectors. Their links are ordered, and live on without this.
//
//     MemoryLinks links(clock);
//     auto hand = HandNode::open(scene, links.listener(), ...);
//     auto coprocessor = CoprocessorNode::open(scene, links.connector(), ...);
//     ...  links.deliver();  hand->poll();  coprocessor->poll();
class MemoryLinks {
  public:
    explicit MemoryLinks(MonotonicClock clock);

    std::unique_ptr<Listener> listener();
    std::unique_ptr<Connector> connector(const Patience& patience = {});

    // The latency of everything sent from now on. Nothing overtakes what was sent before.
    void set_latency(std::chrono::nanoseconds latency);
    // Asked for every message, and with null for the news that an end has closed. False: it is lost without a
    // trace at either end.
    void set_carries(std::function<bool(const proto::Envelope*)> carries);

    // Hands over what has arrived by now; all callbacks come from here. Returns whether there was anything.
    bool deliver();
    // When the next thing arrives; nothing if nothing is under way.
    std::optional<MonotonicTime> next_arrival() const;

  private:
    struct End;
    struct Network;
    class EndLink;
    class MemoryListener;
    class MemoryConnector;

    std::shared_ptr<Network> network_;
};

}  // namespace afferent
