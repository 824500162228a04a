// Fits the strengths of the filter's noise to a recorded force: those that predict it best.
#pragma once

#include <vector>

#include "afferent/decoders/afferent_fit.hpp"
#include "afferent/decoders/force_belief.hpp"

namespace afferent {

struct MotionFit {
    // As before, but for the speeds of hold, movement and contact, and the drift of the hold.
    ForceBelief::Parameters force;
    // The mean log density, in units of 1/N, of a sample as predicted from those before it: with the
    // parameters that the fit began with, and with these.
    double score_before;
    double score;
    // Samples by how uncertain their prediction was, in groups of equal size: the predicted standard
    // deviation and the error, both root mean square. They are equal where the model is calibrated.
    struct Foretold {
        double sigma_n;
        double error_n;
    };
    std::vector<Foretold> foretold;
};

// By maximum likelihood, with each prediction taken for the Gaussian of its mean and variance. One strength
// is varied after the other, each within a factor of thirty of where it began, until a round gains nothing.
// There are at least two points of the force, each with an error of `noise_n`.
MotionFit fit_motions(const ForceTrace& force, double noise_n, const ForceBelief::Parameters& from = {});

}  // namespace afferent
