// The counts of a coprocessor on a link. Included by programs that report on one.
#pragma once

#include <cstdint>
#include <limits>

#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/link_totals.hpp"

namespace afferent {

// Counts over all sessions.
struct CoprocessorNode::Report {
    std::uint64_t sessions = 0;
    std::uint64_t broken_sessions = 0;
    std::uint64_t interrupted_sessions = 0;  // ended by the hand before the scene's end
    LinkTotals link;
    struct Counts {
        std::uint64_t samples = 0;
        std::uint64_t events = 0;
        std::uint64_t packets = 0;
        std::uint64_t raw_sample_bytes = 0;
        // The size of all packets as frames of a stream, without the overhead of the transport.
        std::uint64_t packet_bytes = 0;
    };
    Counts counts;
    // The neurons start again from rest whenever a new hand sends them its samples; counted from then on.
    Counts since_begin;
    std::uint64_t times_begun = 1;
    double hand_gain = std::numeric_limits<double>::quiet_NaN();  // the last that the hand reported
};

}  // namespace afferent
