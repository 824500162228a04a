// From the plan of a patch to the neurons that carry it out.
#pragma once

#include <memory>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/shard.hpp"
#include "afferent/scene/patch_plan.hpp"

namespace afferent {

// `count` afferents of the patch from the begin-th on. A neuron that fires more often than that between two
// scans ends the run. Shards that are never advanced at the same time may share scratch memory.
std::unique_ptr<Shard> make_shard(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count,
                                  std::uint32_t spikes_per_window,
                                  const std::shared_ptr<DenseScratch>& scratch = {});

}  // namespace afferent
