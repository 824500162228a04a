// The exact solution over one fixed interval, as polynomials in the conductance.
#pragma once

#include <array>
#include <optional>

namespace afferent {

// For a fixed a and interval, Φ and X/g of Propagator are smooth functions of one variable, g at the
// beginning of the interval. For g from 0 to g_max the relative error of X is at most `tolerance`, and the
// error of Φ at most `tolerance` times Φ + X: where a strong conductance makes Φ tiny, its own last digits do
// not matter.
//
//     Φ = Σ phi[k] u^k      X = g Σ chi[k] u^k      Ψ = 1 − Φ − X      u = 2 g/g_max − 1
struct IntervalPolynomials {
    static constexpr int most = 32;
    static constexpr double tolerance = 2e-14;

    double g_max;
    int count;  // of coefficients; even
    std::array<double, most> phi;
    std::array<double, most> chi;

    // With as few coefficients as will do, or with so many. Nothing if the tolerance cannot be met.
    static std::optional<IntervalPolynomials> fit(double a, double interval, double g_max);
    static std::optional<IntervalPolynomials> fit(double a, double interval, double g_max, int count);
};

}  // namespace afferent
