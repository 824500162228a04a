// Question: what must a link carry? Bytes per second for events and for every honest alternative, in the same
// frames, with the time that coding takes; and the latency of packets.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/link_schemes.hpp"
#include "bench/transport_bench.hpp"

namespace afferent {

// Touch that a link has to carry: a scene at rest and in its grasp or its recording, and neurons that fire at
// random, for each number of elements; and recorded grip forces on the scene's own elements.
struct BandwidthScenes {
    std::string scene;
    std::vector<std::string> force_tables;
    std::vector<std::uint32_t> elements;
};

// Says on standard error how far it is. Throws SceneError or std::runtime_error.
std::vector<LinkActivity> link_activities(const BandwidthScenes& scenes);

// Every scheme on it.
std::vector<SchemeResult> measure_schemes(const LinkActivity& activity);

// What force can be decoded from each, where the activity comes from one.
void measure_force_errors(const LinkActivity& activity, std::vector<SchemeResult>& results);

struct BandwidthRow {
    const LinkActivity* activity;
    SchemeResult result;

    double bytes_per_s() const { return static_cast<double>(result.bytes) / activity->seconds_long(); }
};

struct Bandwidth {
    std::vector<BandwidthRow> rows;
    std::vector<TransportResult> transports;
};

// Every scheme on every activity, then the transports. The activities must outlive the result. `progress` is
// told the fraction that is done.
Bandwidth measure_bandwidth(const std::vector<LinkActivity>& activities,
                            const std::function<void(double)>& progress);

}  // namespace afferent
