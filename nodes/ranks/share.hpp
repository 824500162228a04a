// How the ranks of a job share out the work on a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "afferent/nodes/ranks/world.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::ranks {

// Whether all ranks have made the same plan, or why not; the same answer at every rank. `plan` is null where
// the scene cannot be planned, for the reason that `failure` gives. To be called by all ranks.
std::optional<std::string> disagreement(World& world, const Plan* plan, const std::string& failure);

// The same for what each rank says, in their order: '+' and its plan, or '-' and why it has none. Empty where
// they agree.
std::string disagreement_in(const std::vector<std::string>& said);

struct Share {
    // Rank 0 sends the samples of each window: nobody else can know them.
    bool samples_are_sent;
    // Of the scene over which the load of each shard was measured; 0: shards are shared out by the number of
    // their afferents.
    double measured_s;
    std::vector<std::uint64_t> afferents;  // of each rank
    // Whether rank 0 samples them all.
    bool first_samples_all;
};

// Leaves the plan the elements that the shards from boundaries[rank] up to boundaries[rank + 1] read, and
// those that nobody reads; or rank 0 all. A sample that several ranks take, one of them counts.
void share_sampling(Plan& plan, const std::vector<std::size_t>& boundaries, std::size_t rank,
                    bool first_samples_all);

// Leaves the plan what this rank does: its shards, its threads, and where samples are computed the elements
// that its afferents read; rank 0 may need to see all of them. To be called by all ranks.
Share share_out(World& world, Plan& plan, bool first_samples_all);

}  // namespace afferent::ranks
