// What a plan takes and sends, at most.
#pragma once

#include "afferent/scene/plan.hpp"

namespace afferent {

// Fills in bytes per neuron and element, events and bytes per second, and the latency.
void add_bounds(Plan& plan);

}  // namespace afferent
