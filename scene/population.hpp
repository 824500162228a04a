// The afferents and the skin of a plan, as pictures and other programs are told of them.
#pragma once

#include "afferent/runtime/population.hpp"
#include "afferent/runtime/skin.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// A place of a patch, where patches lie beside each other: every coordinate that leaves the scene goes
// through this.
Position on_map(const PatchPlan& patch, const Position& place);

Population population_of(const Plan& plan);
Skin skin_of(const Plan& plan);

// Where the scene's first stimulus goes, from the direction of x towards that of y; that of x where it stays.
double stimulus_direction_deg(const Scene& scene);

}  // namespace afferent
