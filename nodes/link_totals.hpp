// The traffic and faults of a link over all sessions of one node. Included by programs that report on a node.
#pragma once

#include <cstdint>

namespace afferent {

class Session;

struct LinkTotals {
    std::uint64_t bytes_sent = 0;
    std::uint64_t bytes_received = 0;
    std::uint64_t dropped_packets = 0;
    std::uint64_t checksum_failures = 0;
    std::uint64_t refused_frames = 0;
    std::uint64_t forged_datagrams = 0;
    std::uint64_t repeated_datagrams = 0;

    void add(const Session& session);
};

}  // namespace afferent
