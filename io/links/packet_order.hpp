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

// Decoders are told of time in order, and a span that was reported lost cannot be given later. So a packet
// waits for those that it has overtaken: until they come, until `longest_wait` is over, or until `most`
// packets wait. Only then does the receiver report a gap.
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
    // Enough for a burst of packets and their parts.
    static constexpr std::size_t most = 32;

    // 0: no packet waits, as on links that keep the order.
    explicit PacketOrder(Duration longest_wait) : longest_wait_(longest_wait) {}

    // True: the packet was copied, and is to be received later.
    bool hold(const proto::Envelope& packet, const PacketReceiver& receiver, MonotonicTime now);
    // The next packet to be received, if it need not wait any longer; valid until the next call of hold(). At
    // MonotonicTime::max() no packet waits.
    Held* next(const PacketReceiver& receiver, MonotonicTime now);
    // When the wait of a packet ends.
    std::optional<MonotonicTime> due() const;

  private:
    Duration longest_wait_;
    // The first `count_` wait, in any order; the others are kept for their memory.
    std::vector<Held> held_;
    std::size_t count_ = 0;
};

}  // namespace afferent
