// How the ranks of a job share out the work on a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/ranks/world.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::ranks {

// Whether all ranks have made the same plan, or why not; the same answer at every rank. `plan` is null where
// the scene cannot be planned, for the reason that `failure` gives. To be called by all ranks.
std::optional<std::string> disagreement(World& world, const Plan* plan, const std::string& failure);

struct Share {
    // Rank 0 sends the samples of each window: nobody else can know them.
    bool samples_are_sent;
    // Of the scene over which the load of each shard was measured; 0: shards are shared out by the number of
    // their afferents.
    double measured_s;
    std::vector<std::uint64_t> afferents;  // of each rank
};

// Leaves the plan the shards of this rank, and its threads. To be called by all ranks.
Share share_out(World& world, Plan& plan);

}  // namespace afferent::ranks
