// What a hand makes of the packets of one session: what they tell, whether they came too late to tell it, and
// whether there are enough of them for the hand to go on.
#pragma once

#include "afferent/io/links/watchdog.hpp"
#include "afferent/io/wire/packet_receiver.hpp"

namespace afferent {

class PacketIntake {
  public:
    struct Limits {
        Duration freeze;  // of silence, until the grip is frozen
        Duration safe;    // and until it is safe
        Duration stale;   // of age, from which on a packet is not used; 0: none is too old
    };

    // Throws ParameterError, as the layout and the watchdog do.
    PacketIntake(const PacketLayout& layout, const Limits& limits, MonotonicTime now)
        : receiver_(layout), watchdog_(limits.freeze, limits.safe, now), stale_(limits.stale) {}

    // What the packet tells. `age(time)` is how long ago that time of the scene was. A packet that is too old
    // tells of a gap, and is no sign of life: a reader that was held up would otherwise act on the past for
    // as long as buffers last.
    template <class Age>
    Result<Reception> receive(const proto::Envelope& packet, MonotonicTime now, const Age& age) {
        const Result<Reception> reception = receiver_.receive(packet);
        if (!reception) return reception;
        if (stale_ > Duration::zero() && age(reception.value().known.end) > stale_)
            return receiver_.discard(reception.value());
        watchdog_.heard(now);
        return reception;
    }

    PacketReceiver& receiver() noexcept { return receiver_; }
    const PacketReceiver& receiver() const noexcept { return receiver_; }
    Watchdog& watchdog() noexcept { return watchdog_; }
    const Watchdog& watchdog() const noexcept { return watchdog_; }

  private:
    PacketReceiver receiver_;
    Watchdog watchdog_;
    Duration stale_;
};

}  // namespace afferent
