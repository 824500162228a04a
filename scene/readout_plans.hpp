// What is read out of each patch besides the grip force, as the scene asks for it and the patch allows.
#pragma once

#include "afferent/scene/plan.hpp"

namespace afferent {

// For a plan whose patches are decided. Throws ParameterError where the scene asks for what none of them can
// have.
ReadoutPlans readout_plans(const Plan& plan);

bool asks_for_readouts(const scene::Decoder& decoder);

void add_readout_items(const Plan& plan, PlanItems& items);

}  // namespace afferent
