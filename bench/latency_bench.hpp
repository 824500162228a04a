// Question: how long does the coprocessor take from samples to a packet?
#pragma once

#include <cstddef>

#include "afferent/scene/scene.hpp"

namespace afferent::bench {

struct Latency {
    double median_us;
    double p99_us;
    double largest_us;
};

// The time from having a span's samples to having its packet as bytes: encoder, neurons, packetizer, codec
// and framing, but no link. The events are checked against a run of the scene before anything is timed.
// Spans with spikes are also listed by themselves. Throws std::runtime_error.
struct LatencyResult {
    std::size_t spans;
    Latency all;
    Latency with_spikes;
    double clock_us;  // what reading the clock adds to each
};
LatencyResult run_latency_bench(const Scene& scene, int repetitions);

}  // namespace afferent::bench
