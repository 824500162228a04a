// The constants of a dense population, computed once from its parameters and scan interval.
#pragma once

#include "afferent/neurons/dense_kernel.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent::dense {

struct Plan {
    Model model;
    int steps;    // equal parts of a scan interval
    bool series;  // false: AdaptingLif computes every crossing
};

// Also serves neurons with other thresholds and a smaller Δg. Throws ParameterError unless the interval is
// above 0 and at most 4 s, to which the stamps of a sweep are limited.
Plan plan(const LifParameters& parameters, Duration scan_interval);

// Neurons of one class can share a plan without more steps than most of them need: a power of two.
int steps_class(const LifParameters& parameters, Duration scan_interval);

}  // namespace afferent::dense
