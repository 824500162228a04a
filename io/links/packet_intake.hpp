// Receives the packets of one session for a hand: what they tell, and whether they came in time.
#pragma once

#include <optional>

#include "afferent/io/wire/packet_receiver.hpp"

namespace afferent {

class PacketIntake {
  public:
    // A packet that is older than `stale` is not used; 0: none is too old. Throws ParameterError, as the
    // layout does.
    PacketIntake(const PacketLayout& layout, Duration stale) : receiver_(layout), stale_(stale) {}

    // What the packet tells. `age(time)` returns how long ago that time of the scene was; nothing where that
    // is not known yet. A packet that is too old or of unknown age is received as a gap, because a reader
    // that was held up would otherwise act on the past until the buffers are empty. So is a packet whose
    // sensors are silent. One that ends after `latest` is refused.
    template <class Age>
    Result<Reception> receive(const proto::Envelope& packet, const Age& age,
                              TimePoint latest = TimePoint::max()) {
        const Result<Reception> received = receiver_.receive(packet, latest);
        if (!received) return received;
        Reception reception = received.value();
        if (stale_ > Duration::zero()) {
            const std::optional<Duration> known = age(reception.known.end);
            reception.age = known.value_or(Duration::max());
            reception.stale = reception.age > stale_;
        }
        return reception.usable() ? reception : receiver_.discard(reception);
    }

    PacketReceiver& receiver() noexcept { return receiver_; }
    const PacketReceiver& receiver() const noexcept { return receiver_; }

  private:
    PacketReceiver receiver_;
    Duration stale_;
};

}  // namespace afferent
