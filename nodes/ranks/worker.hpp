// The work of every rank but the first: to compute its neurons, and to send their events.
#pragma once

#include "afferent/nodes/ranks/share.hpp"
#include "afferent/nodes/ranks/world.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent::ranks {

// Computes the plan's shards, as the share says. Returns when rank 0 has said so; what goes wrong is told to
// rank 0.
void work(const World& world, Plan& plan, const Share& share);

}  // namespace afferent::ranks
