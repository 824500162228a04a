// What a dense population is built from, found once from its parameters and frame interval.
#pragma once

#include "afferent/neurons/dense_kernel.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent::dense {

struct Plan {
    Model model;
    int steps;  // equal parts of a frame
};

// For neurons with these parameters, or with other thresholds and a Δg up to that of these. Throws
// ParameterError where the dense form cannot keep its promise.
Plan plan(const LifParameters& parameters, Duration frame);

}  // namespace afferent::dense
