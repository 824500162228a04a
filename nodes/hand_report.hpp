// The counts of a hand on a link. Included by programs that report on one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "afferent/io/wire/packet_counts.hpp"
#include "afferent/nodes/hand_device.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/link_totals.hpp"
#include "afferent/runtime/grip_state.hpp"

namespace afferent {

// Counts over all sessions.
struct HandNode::Report {
    std::uint64_t sessions = 0;
    std::uint64_t broken_sessions = 0;
    std::uint64_t interrupted_sessions = 0;  // ended by the peer before the scene's end
    std::uint64_t refused_peers = 0;
    PacketCounts received;
    LinkTotals link;  // including refused packets and stray datagrams
    // Bytes of samples for the coprocessor as frames of a stream; `link` includes the overhead of the
    // transport.
    std::uint64_t feed_bytes = 0;
    std::uint64_t freezes = 0;
    std::uint64_t safe_states = 0;
    GripState state = GripState::safe;
    std::string reason;               // why the grip is not operating
    bool real_time_priority = false;  // whether the loop's thread has it
    // Dropped because a queue to or from the loop was full; a scan, also because it could not be used.
    std::uint64_t dropped_packets = 0;
    std::uint64_t dropped_scans = 0;
    std::uint64_t unwritten_steps = 0;
    std::uint64_t lost_events = 0;          // that an output of live events could not send
    std::optional<HandReadings> hand = {};  // of a hand on a line
};

}  // namespace afferent
