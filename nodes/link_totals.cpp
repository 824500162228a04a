#include "afferent/nodes/link_totals.hpp"

#include "afferent/io/links/session.hpp"

namespace afferent {

void LinkTotals::add(const Session& session) {
    const LinkCounts& link = session.counts();
    bytes_sent += link.bytes_out;
    bytes_received += link.in.bytes;
    dropped_packets += link.dropped;
    checksum_failures += link.in.checksum_failures;
    refused_frames += link.in.refused + session.refused_messages();
    forged_datagrams += link.in.forged;
    repeated_datagrams += link.in.repeated;
}

}  // namespace afferent
