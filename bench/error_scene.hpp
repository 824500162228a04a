// The scenes on which error and run time are compared.
#pragma once

#include <string>
#include <vector>

#include "bench/workload.hpp"

namespace afferent::bench {

struct ErrorScene {
    Workload workload;
    std::vector<std::size_t> judged;  // neurons whose true spikes are computed
    // Where the drives come from, for the force error: drive = gain · force + bias. Empty where not known.
    std::vector<double> force_n;        // row by row
    std::vector<double> gain_mv_per_n;  // one for each neuron
    std::vector<double> bias_mv;
};

// The paper's grasp; a drive with noise at 1 kHz; fast stiff and slow strong adaptation; 1,000 afferents that
// differ; a crowd of 10,000. The quick form of each is shorter.
std::vector<ErrorScene> error_scenes(bool quick);

}  // namespace afferent::bench
