// From sample to packet: how long the coprocessor takes.
#pragma once

#include <cstddef>

#include "afferent/scene/scene.hpp"

namespace afferent::bench {

struct Latency {
    double median_us;
    double p99_us;
    double largest_us;
};

// How long from a span's samples in hand to its packet as bytes on the link: encoder, neurons, packetizer,
// codec and framing; no link. The events are checked against a run of the scene before anything is timed.
// Spans in which nothing fires and spans with spikes are told apart. Throws std::runtime_error.
struct LatencyResult {
    std::size_t spans;
    Latency all;
    Latency with_spikes;
    double clock_us;  // what reading the clock adds to each
};
LatencyResult run_latency_bench(const Scene& scene, int repetitions);

}  // namespace afferent::bench
