// Throughput and latency of packets over this machine's own transports.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "afferent/runtime/time.hpp"

namespace afferent {

struct TransportResult {
    std::string transport;
    Duration packet{};
    double events_per_s = 0;  // encoded, sent, received and decoded, one after the other on one thread
    double p50_us = 0;        // from the closing of a packet to having its events
    double p99_us = 0;
};

// Packets of that span from 100,000 addresses that fire at 20 Hz, over `in_process`, `unix`, `tcp`, `tls`,
// `udp` and `udp_sealed`, over the latter two in parts of at most 20,000 events; and from 1000 addresses over
// `serial`, a pair of pseudo-terminals, which is given what a line of 921,600 baud takes. What is lost is
// left out.
std::vector<TransportResult> measure_transports(const std::vector<Duration>& packets);

}  // namespace afferent
