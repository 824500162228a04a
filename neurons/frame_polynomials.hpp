// The exact solution over one fixed interval, as polynomials in the conductance.
#pragma once

#include <array>
#include <optional>

namespace afferent {

// For a fixed a and interval, Φ and X/g of Propagator are smooth functions of g at the interval's beginning
// alone. For g from 0 to g_max, X is right to `tolerance`, relative, and Φ to that part of Φ + X: where a
// strong conductance leaves next to nothing of the beginning, its own last digits do not matter.
//
//     Φ = Σ phi[k] u^k      X = g Σ chi[k] u^k      Ψ = 1 − Φ − X      u = 2 g/g_max − 1
struct FramePolynomials {
    static constexpr int most = 32;
    static constexpr double tolerance = 2e-14;

    double g_max;
    int count;  // of coefficients; even
    std::array<double, most> phi;
    std::array<double, most> chi;

    // Nothing, if the tolerance cannot be met.
    static std::optional<FramePolynomials> fit(double a, double interval, double g_max);
};

}  // namespace afferent
