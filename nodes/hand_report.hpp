// The counts of a hand on a link. Included by programs that report on one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "afferent/io/wire/packet_counts.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/link_totals.hpp"
#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// What a hand on a line of its own says of itself, and what has gone over that line.
struct HandReadings {
    struct Motor {
        const char* name = "";
        double position_deg = 0;
        double current_a = 0;
    };
    std::array<Motor, 8> motors{};
    std::size_t motor_count = 0;
    std::array<double, 32> zero_counts{};  // of the sensors, as they are taken to be now
    std::size_t sensor_count = 0;
    unsigned temperature_status = 0;  // 0: neither hot nor cold
    bool answering = false;           // a reply has come within freeze_ms
    bool driven = false;              // it is commanded, and not only asked for its readings
    std::uint64_t commands = 0;
    std::uint64_t replies = 0;
    std::uint64_t unanswered = 0;
    std::uint64_t refused_frames = 0;
    std::uint64_t implausible_replies = 0;  // whole, and not what this hand could say
    std::uint64_t lost_lines = 0;           // how often the line has failed
    std::uint64_t zeros_taken = 0;
    std::uint64_t zeros_refused = 0;
    // From the arrival of a sample to the first command that it is known to have reached.
    Duration sample_to_command_p50{};
    Duration sample_to_command_p99{};
    Duration sample_to_command_max{};
};

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
    // Dropped because a queue to or from the loop was full.
    std::uint64_t dropped_packets = 0;
    std::uint64_t dropped_scans = 0;
    std::uint64_t unwritten_steps = 0;
    std::uint64_t lost_events = 0;          // that an output of live events could not send
    std::optional<HandReadings> hand = {};  // of a hand on a line
};

}  // namespace afferent
