// The strengths of the filter's noise that foretell a recorded force best.
#pragma once

#include <vector>

#include "afferent/decoders/afferent_fit.hpp"
#include "afferent/decoders/force_belief.hpp"

namespace afferent {

struct MotionFit {
    // As before, but for the speeds of hold, movement and contact, and the drift of the hold.
    ForceBelief::Parameters force;
    // The mean log density, in units of 1/N, of a sample under what was believed before it: with the
    // parameters that the fit began with, and with these.
    double score_before;
    double score;
    // Samples by how uncertain the belief had been, in groups of equal size: the standard deviation that it
    // had told, and the error that there was, root mean square. Equal, where the belief is honest.
    struct Foretold {
        double sigma_n;
        double error_n;
    };
    std::vector<Foretold> foretold;
};

// By maximum likelihood, where a belief counts as the Gaussian of its mean and variance: one strength after
// the other, each within a thirtieth and thirty times of what it was, until a round gains nothing. The points
// of the force, of which there are at least two, are each off by `noise_n`.
MotionFit fit_motions(const ForceTrace& force, double noise_n, const ForceBelief::Parameters& from = {});

}  // namespace afferent
