// The constants of a dense population, computed once from its parameters and scan interval.
#pragma once

#include "afferent/neurons/dense_kernel.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent::dense {

// A sweep in so many steps takes some ten times less than prediction of neurons whose drives change, where
// the polynomials hold their g. Where they do not, AdaptingLif computes each step, as long as prediction for
// a scan.
inline constexpr int most_steps = 8;

struct Plan {
    Model model;
    int steps;    // equal parts of a scan interval
    bool series;  // false: AdaptingLif computes every crossing
};

// Throws ParameterError unless the interval is above 0 and at most 4 s, to which the stamps of a sweep are
// limited.
void check(const LifParameters& parameters, Duration scan_interval);

// Also serves neurons with other thresholds and a smaller Δg. Throws ParameterError as check().
Plan plan(const LifParameters& parameters, Duration scan_interval);

// What a plan depends on. Δg is rounded up by at most a quarter of an octave, so that neurons whose Δg is
// nearly the same share a plan.
LifParameters planned(LifParameters parameters);

// Neurons of one class can share a plan without more steps than most of them need: a power of two, above
// most_steps where no number of steps makes the series hold.
int steps_class(const LifParameters& parameters, Duration scan_interval);

}  // namespace afferent::dense
