// The adapting membrane over a short interval, as a power series: the cheap form of the exact solution, for
// the intervals that are most frequent.
#pragma once

#include <array>

namespace afferent {

// With x = a g as the independent variable, Membrane's equation is
//
//     x dz/dx = (a + x) z − x W + a c,
//
// so the Taylor coefficients around any x₀ follow from each other. With ε = x/x₀ − 1 = expm1(−s/a), and ε₁ at
// the end of the interval,
//
//     z = Σ t_n (ε/ε₁)^n
//     (n + 1) t_(n+1) = ε₁ (a + x₀ − n) t_n + ε₁² x₀ t_(n−1) + [n = 0] ε₁ (a c − x₀ W) − [n = 1] ε₁² x₀ W:
//
// two multiplications per term, and one exponential in all. Time follows from ε as s = −a log1p(ε).
class ShortInterval {
  public:
    // The longest interval, in units of tau_m, for which the series is accurate to rounding: within it the
    // solution grows by at most e², and g falls by at most a quarter.
    static double longest(double a, double g) noexcept;

    // `fall` is ε₁ of an interval no longer than longest(a, g).
    ShortInterval(double a, double reversal_mv, double gap_mv, double g, double excess_mv,
                  double fall) noexcept;

    // If false, the terms do not fall off soon enough and the series must not be used.
    bool converged() const noexcept { return converged_; }
    // The gap at the end.
    double end_mv() const noexcept { return end_mv_; }
    // ε where the gap is 0. The gap is positive at the beginning and not at the end.
    double root() const noexcept;

  private:
    double value(double part) const noexcept;
    double guess() const noexcept;

    static constexpr int most = 32;
    std::array<double, most> terms_;  // t_n; the first count_ are set, a multiple of four
    int count_ = 0;
    bool converged_ = false;
    double a_, x_, reversal_mv_, excess_mv_;
    double fall_;
    double end_mv_;
};

}  // namespace afferent
