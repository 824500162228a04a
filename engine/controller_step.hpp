// What a controller knew and did at one of its steps. To be included by whoever takes steps: motors, outputs,
// recorders.
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
    std::optional<double> true_force_n;  // where it is known
};

// The grip as a whole.
struct GripStep {
    TimePoint time;
    std::optional<double> true_force_n;  // where the hand is simulated
    Estimate estimate;
    double gain;
    double closing_counts;  // EMG, as sampled
    Effort effort;
    double command;  // to the motor, -1 (open) to 1 (close)
};

struct ControllerStep : GripStep {
    // Where the scene asks for them: all of them at each step, in the order of the plan's parts.
    std::vector<PartForce> parts;
    // What the read-outs have told since the last step: at most one of each.
    std::vector<PatchReadout> readouts;
};

}  // namespace afferent
