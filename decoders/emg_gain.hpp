// The factor on the user's closing EMG: the harder the grip, the less the hand closes.
#pragma once

#include "afferent/decoders/estimate.hpp"

namespace afferent {

// After the paper, an exponential decay with force:
//
//     1                          F < onset
//     exp(−(F − onset)/lambda)   onset <= F < limit
//     0                          F >= limit
//
// The continuous shape subtracts the step at the limit and rescales, so that it falls from 1 to 0 without
// one.
class EmgGain {
  public:
    enum class Shape { exponential, continuous };
    struct Parameters {
        double onset_n = 2;
        double lambda_n = 3;
        double limit_n = 10;
        Shape shape = Shape::exponential;
        // The gain is that of the estimate plus so many of its standard deviations.
        double upper_bound_sigmas = 0;
        bool operator==(const Parameters&) const = default;
    };

    // Throws ParameterError: onset_n >= 0, lambda_n > 0, limit_n > onset_n, upper_bound_sigmas >= 0, all
    // finite.
    explicit EmgGain(const Parameters& parameters);

    // In [0, 1] for every force; 0 for NaN, so that an unknown force does not close the hand.
    double operator()(double force_n) const noexcept;
    // The gain of the upper bound of an estimate. Where upper_bound_sigmas is 0, sigma is not looked at;
    // otherwise a sigma that is NaN or negative gives 0.
    double operator()(const Estimate& estimate) const noexcept;

  private:
    Parameters parameters_;
    double at_limit_;  // what the continuous shape subtracts
};

}  // namespace afferent
