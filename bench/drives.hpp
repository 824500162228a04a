// The drive that each neuron of a scene is given: for benchmarks and for comparing with other solvers.
#pragma once

#include <vector>

#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

struct NeuronDrive {
    struct Step {
        TimePoint time;
        double drive_mv;  // held until the next step
    };
    NeuronModel parameters;
    std::vector<Step> steps;  // the first at the beginning of the scene
};

// By address. Runs the scene: where the hand is simulated, its drives depend on its spikes.
Result<std::vector<NeuronDrive>> record_drives(const Plan& plan);

}  // namespace afferent
