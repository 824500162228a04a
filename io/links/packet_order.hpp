// Puts packets that have overtaken each other back into the order in which they were sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {

// A decoder is told of time in its order, and what it was told is lost cannot be given to it later. So a
// packet waits for those that it has overtaken: until they come, for `longest_wait` at most, or until `most`
// packets wait. Only then is the receiver told of a gap.
//
//     if (!order.hold(packet, receiver, now)) receiver.receive(packet);
//     while (const auto* next = order.next(receiver, now)) receiver.receive(next->packet);
class PacketOrder {
  public:
    struct Held {
        proto::Envelope packet;
        MonotonicTime arrived{};
        PacketReceiver::Standing standing;
    };
    // A burst of packets and their parts.
    static constexpr std::size_t most = 32;

    // 0: none waits, as where packets come in order.
    explicit PacketOrder(Duration longest_wait) : longest_wait_(longest_wait) {}

    // True: the packet was copied, and is not to be received yet.
    bool hold(const proto::Envelope& packet, const PacketReceiver& receiver, MonotonicTime now);
    // The next to be received, if it need not wait any longer; valid until the next call of hold(). At
    // MonotonicTime::max() nothing waits.
    Held* next(const PacketReceiver& receiver, MonotonicTime now);
    // When one has waited for long enough.
    std::optional<MonotonicTime> due() const;

  private:
    Duration longest_wait_;
    // The first `count_` wait, in any order; the others are kept for the memory that they have.
    std::vector<Held> held_;
    std::size_t count_ = 0;
};

}  // namespace afferent
