// The exact solution of the adapting membrane over an interval of any length.
#pragma once

namespace afferent {

// For dz/ds = −(1 + g) z + g W − c with g(s) = g₀ e^(−s/a), time in units of tau_m and a = tau_g/tau_m:
//
//     z(s) = z₀ Φ − c Ψ + W X
//     Φ = exp(−s − a (g₀ − g(s)))
//     Ψ = ∫₀ˢ exp(−u − a g(s) expm1(u/a)) du
//     X = ∫₀ˢ g(s) exp(u/a − u − a g(s) expm1(u/a)) du        (Φ + Ψ + X = 1)
//
// All three lie in [0, 1], and each is correct to a few units in its last place. That includes X where it is
// far too small to be computed as 1 − Φ − Ψ.
struct Propagator {
    double phi;
    double psi;
    double chi;
    double g;
};

// For every a > 0, g₀ >= 0 and s >= 0.
Propagator propagate(double a, double g, double s) noexcept;

}  // namespace afferent
