// The work of every rank but the first: to compute its neurons, and to send their events.
#pragma once

#include "afferent/ranks/world.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::ranks {

// Returns when rank 0 has said so. Computes the plan's shards; `gets_samples`: rank 0 sends them, window by
// window. What goes wrong is told to rank 0.
void work(const World& world, Plan& plan, bool gets_samples);

}  // namespace afferent::ranks
