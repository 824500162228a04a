// The amplitude of an EMG: rectified, low-passed, as a fraction of the strongest contraction.
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

//     envelope += (1 − exp(−dt/tau)) (|emg − rest| / full scale − envelope)
class EmgEnvelope {
  public:
    struct Parameters {
        double time_constant_ms = 40;
        double rest_counts = 2048;
        double full_scale_counts = 500;
    };

    // `period` is the sampling interval. Throws ParameterError: time constant, full scale and period > 0.
    EmgEnvelope(const Parameters& parameters, Duration period) : parameters_(parameters) {
        require(parameters.time_constant_ms > 0, "envelope_ms", "> 0", parameters.time_constant_ms);
        require(parameters.full_scale_counts > 0, "full_scale_counts", "> 0", parameters.full_scale_counts);
        require(true, "rest_counts", "finite", parameters.rest_counts);
        require(period > 0ns, "emg_rate_hz", "> 0", seconds(period));
        step_ = -std::expm1(-Milliseconds(period).count() / parameters.time_constant_ms);
    }

    // Takes the next sample; returns the envelope, 0 to 1.
    double operator()(double counts) noexcept {
        const double amplitude = std::abs(counts - parameters_.rest_counts) / parameters_.full_scale_counts;
        envelope_ += step_ * (amplitude - envelope_);
        return std::clamp(envelope_, 0.0, 1.0);
    }

  private:
    Parameters parameters_;
    double step_;
    double envelope_ = 0;
};

}  // namespace afferent
