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
// one. The force F is that of the estimate and so many of its standard deviations. An estimate that is
// doubtful may be far below the force, so that one rule keeps to the safe side (docs/safe_state.md):
//
//     doubt       gain
//     none        that of force + upper_bound_sigmas · sigma
//     saturated   `saturated`, but no more than that of the force
//     any other   that of force + max(upper_bound_sigmas, 2) · sigma
class EmgGain {
  public:
    enum class Shape { exponential, continuous };
    // The force by which the gain of a doubtful estimate is computed.
    enum class Doubtful { by_upper_bound, as_estimated };
    struct Parameters {
        double onset_n = 2;
        double lambda_n = 3;
        double limit_n = 10;
        Shape shape = Shape::exponential;
        // The gain is that of the estimate plus so many of its standard deviations.
        double upper_bound_sigmas = 0;
        Doubtful doubtful = Doubtful::by_upper_bound;
        // The gain while the sensors are at full scale.
        double saturated = 0;
        bool operator==(const Parameters&) const = default;
    };

    // Throws ParameterError: onset_n >= 0, lambda_n > 0, limit_n > onset_n, upper_bound_sigmas >= 0, all
    // finite; saturated 0 to 1.
    explicit EmgGain(const Parameters& parameters);

    // In [0, 1] for every force; 0 for NaN, so that an unknown force does not close the hand.
    double operator()(double force_n) const noexcept;
    // The gain by the rule above. A sigma that the rule does not use is ignored; otherwise a sigma that is
    // NaN or negative gives 0.
    double operator()(const Estimate& estimate) const noexcept;

  private:
    Parameters parameters_;
    double at_limit_;  // what the continuous shape subtracts
};

}  // namespace afferent
