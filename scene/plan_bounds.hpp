// What a plan takes and sends, at most.
#pragma once

#include "afferent/scene/plan.hpp"

namespace afferent {

// Fills in bytes per neuron and element, events and bytes per second, and the latency.
void add_bounds(Plan& plan);

// An upper bound on the rate of an afferent of the patch, at its sensors' full scale; may be infinite.
double highest_rate_hz(const Plan& plan, const PatchPlan& patch, std::uint32_t afferent);

// Whether that is above 0 for any afferent of the patch.
bool can_fire(const Plan& plan, const PatchPlan& patch);

}  // namespace afferent
