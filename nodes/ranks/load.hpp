// What computing a scene's neurons takes, shard by shard, measured over its beginning.
#pragma once

#include <span>
#include <vector>

#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::ranks {

// The samples of the beginning of a scene, in its windows.
struct Beginning {
    struct Sampled {
        TimePoint time;
        Address first;
        std::uint32_t count;
        std::size_t window;
    };
    std::vector<Sampled> scans;
    std::vector<double> forces_n;  // of the scans, one after the other
    std::vector<TimePoint> ends;   // of the windows
    double sampling_s;             // processor time without that of the first window

    TimePoint end() const { return ends.back(); }
};

// Whether the samples are known before the run: not those of a hand, or of standard input.
bool is_known_before(const Plan& plan);

// Takes some samples for each element, but no more than a quarter of the scene. The same at every rank.
Result<Beginning> beginning_of(Plan& plan);

struct ShardLoads {
    std::vector<double> seconds;  // of processor time, by shard, without the first window, which samples all
    std::vector<Event> events;    // of all these shards
};

// Computes these shards of the plan, each by itself, over the beginning. Throws SpikeStormError.
ShardLoads measure(Plan& plan, std::span<const Plan::ShardPlan> shards, const Beginning& beginning);

// The loads of the plan's shards, and to each its part of the time that sampling took: that of a patch is
// shared by the afferents that read it.
std::vector<double> with_sampling(std::vector<double> loads, const Plan& plan, const Beginning& beginning);

using EventsOfRanks = std::vector<std::vector<Event>>;

// The processor time of everything else that rank 0 does over the beginning, given the events of each rank's
// neurons: sampling, gathering, packets, decoding. Writes no output of the scene.
Result<double> rest_of_run(Plan& plan, const Beginning& beginning, EventsOfRanks events);

}  // namespace afferent::ranks
