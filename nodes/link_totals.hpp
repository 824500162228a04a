// What has gone over a link, and what was wrong with it, in all sessions of one node.
#pragma once

#include <cstdint>

#include "afferent/io/links/session.hpp"

namespace afferent {

struct LinkTotals {
    std::uint64_t bytes_sent = 0;
    std::uint64_t bytes_received = 0;
    std::uint64_t dropped_packets = 0;
    std::uint64_t checksum_failures = 0;
    std::uint64_t refused_frames = 0;
    std::uint64_t forged_datagrams = 0;
    std::uint64_t repeated_datagrams = 0;

    void add(const Session& session) {
        const LinkCounts& link = session.counts();
        bytes_sent += link.bytes_out;
        bytes_received += link.in.bytes;
        dropped_packets += link.dropped;
        checksum_failures += link.in.checksum_failures;
        refused_frames += link.in.refused + session.refused_messages();
        forged_datagrams += link.in.forged;
        repeated_datagrams += link.in.repeated;
    }
};

}  // namespace afferent
