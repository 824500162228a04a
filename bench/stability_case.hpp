// Stiff, extreme and meaningless input for a neuron.
#pragma once

#include <string>
#include <vector>

#include "bench/workload.hpp"

namespace afferent::bench {

struct StabilityCase {
    Workload workload;       // of one neuron
    bool meaningful = true;  // otherwise there is no truth, and the right thing is to refuse
};

// The corners of the ranges (time constants apart by 1e-8 to 1e8, Δg to 1e6, drives to ±1e9 mV and around the
// rheobase, intervals from 1 ns), random parameter sets between them, and NaN, infinities, denormals, zero
// and negative values at every input. The quick form is a part of these.
std::vector<StabilityCase> stability_cases(bool quick);

}  // namespace afferent::bench
