// Counts of the packets that a hand received. Included by programs that report on a hand.
#pragma once

#include <cstdint>

#include "afferent/runtime/time.hpp"

namespace afferent {

struct PacketCounts {
    std::uint64_t packets = 0;
    std::uint64_t events = 0;
    std::uint64_t gaps = 0;
    Duration unknown = Duration::zero();  // the total length of all gaps
    std::uint64_t lost_events = 0;        // as reported by the sender, a few packets after a gap
    std::uint64_t out_of_order = 0;
    std::uint64_t refused = 0;
    std::uint64_t late = 0;   // arrived after the time at which it should have acted
    std::uint64_t stale = 0;  // too old to be used; their events are among the lost
};

}  // namespace afferent
