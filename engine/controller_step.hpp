// One step of a controller: its input, estimate and command. Included by whatever takes steps: motors,
// outputs, recorders.
#pragma once

#include <optional>
#include <vector>

#include "afferent/decoders/estimate.hpp"
#include "afferent/decoders/readout.hpp"
#include "afferent/runtime/effort.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The force on a patch or an element.
struct PartForce {
    Estimate estimate;
    std::optional<double> true_force_n;  // if known
};

// The grip as a whole.
struct GripStep {
    TimePoint time;
    std::optional<double> true_force_n;  // if known
    Estimate estimate;
    double gain;
    double closing_counts;  // of the EMG, as sampled
    Effort effort;
    double command;                       // to the motor, -1 (open) to 1 (close)
    TimePoint known_until = scene_start;  // the events before this time are in the estimate
};

struct ControllerStep : GripStep {
    // If the scene asks for parts: all of them, in the order of the plan's parts. Otherwise empty.
    std::vector<PartForce> parts;
    // The read-outs since the last step, at most one of each kind and patch.
    std::vector<PatchReadout> readouts;
};

}  // namespace afferent
