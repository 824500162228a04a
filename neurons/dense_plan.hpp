// The constants of a dense population, computed once from its parameters and scan interval.
#pragma once

#include "afferent/neurons/dense_kernel.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent::dense {

struct Plan {
    Model model;
    int steps;  // equal parts of a scan interval
};

// Also serves neurons with other thresholds and a smaller Δg. Throws ParameterError where the dense form
// would be off by more than 1 ns.
Plan plan(const LifParameters& parameters, Duration scan_interval);

}  // namespace afferent::dense
