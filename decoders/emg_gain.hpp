// The factor on the user's closing EMG, which falls as the grip force grows. Included by whoever builds a
// scene or an EmgControl.
#pragma once

#include "afferent/decoders/estimate.hpp"

namespace afferent {

// The gain decays exponentially with force, as in the paper:
//
//     1                          F < onset
//     exp(−(F − onset)/lambda)   onset <= F < limit
//     0                          F >= limit
//
// The continuous shape has no step at the limit: it is shifted and rescaled to fall from 1 to 0. F is the
// estimate plus upper_bound_sigmas standard deviations. The force may be far above a doubtful estimate; the
// rule for doubt keeps the gain on the safe side (docs/safe_state.md):
//
//     doubt       gain
//     none        that of force + upper_bound_sigmas · sigma
//     saturated   `saturated`, but no more than that of the force
//     any other   that of force + max(upper_bound_sigmas, 2) · sigma
//
// If the estimate says which force is coming, its gain holds where it is lower.
class EmgGain {
  public:
    enum class Shape { exponential, continuous };
    // The force from which the gain of a doubtful estimate is computed.
    enum class Doubtful { by_upper_bound, as_estimated };
    struct Parameters {
        double onset_n = 2;
        double lambda_n = 3;
        double limit_n = 10;
        Shape shape = Shape::exponential;
        // How many standard deviations are added to the estimate.
        double upper_bound_sigmas = 0;
        Doubtful doubtful = Doubtful::by_upper_bound;
        // The gain while the sensors are at full scale.
        double saturated = 0;
        bool operator==(const Parameters&) const = default;
    };

    // Throws ParameterError unless onset_n >= 0, lambda_n > 0, limit_n > onset_n, upper_bound_sigmas >= 0,
    // all finite, and saturated is in [0, 1].
    explicit EmgGain(const Parameters& parameters);

    // In [0, 1] for every force. 0 for NaN: an unknown force does not close the hand.
    double operator()(double force_n) const noexcept;
    // The gain by the rule above. If the rule uses sigma, a NaN or negative sigma gives 0.
    double operator()(const Estimate& estimate) const noexcept;

  private:
    Parameters parameters_;
    double at(double force_n, double sigma_n, double sigmas) const noexcept;

    double at_limit_;  // what the continuous shape subtracts
};

}  // namespace afferent
