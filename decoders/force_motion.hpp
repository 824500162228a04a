// How a force and its rate of change move within a step of time.
#pragma once

#include <cstddef>

#include "afferent/decoders/decoder_parameters.hpp"

namespace afferent {

// What a step makes of a force F and its rate V, with noise of a covariance:
//
//     F' = a F + b V,      V' = c F + d V
struct ForceFlow {
    double a = 1, b = 0, c = 0, d = 1;
    double ff = 0, fv = 0, vv = 0;
};

// A rate that wanders around 0 with the standard deviation σ (an Ornstein–Uhlenbeck process). Exact.
//
//     dF = V dt + q dW,      dV = −V/τ dt + σ sqrt(2/τ) dB
ForceFlow wandering(const ForceMotion& motion, double dt_s) noexcept;

// A force that returns to 0 without swinging below (a critically damped oscillator). Exact in the mean; the
// noise is that of a step that is short against τ.
//
//     dF = V dt + q dW,      dV = −(2 V + F/τ)/τ dt + σ sqrt(2/τ) dB
ForceFlow returning(const ForceMotion& motion, double dt_s) noexcept;

// The flow of that motion.
ForceFlow flow(const ForceBeliefParameters& parameters, std::size_t motion, double dt_s) noexcept;

// 1 − e^(−r), for r >= 0.
double lost_fraction(double r) noexcept;

}  // namespace afferent
