#include "afferent/neurons/propagator.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

namespace afferent {
namespace {

// Below this value of a·g the solution is a power series in it, above it a quadrature. Both remain accurate
// several times beyond the limit.
constexpr double weak = 0.5;

// For small a·g, exp(−a g(u)) is expanded in powers, each of which has a closed integral:
//
//     Ψ = e^(x_s) Σ_k (−x₀)^k/k! P_k      P_k = ∫₀ˢ e^(−k t/a) e^(−(s − t)) dt      x = a g
//     X = e^(x_s) g₀ Σ_k (−x₀)^k/k! P_(k+1)
//
// P_k is a divided difference of exponentials, positive, and regular at k = a.
double divided_difference(double p, double q, double s) {
    const double gap = std::abs(p - q);
    const double decay = std::exp(-std::min(p, q) * s);
    return gap * s > 0 ? decay * (-std::expm1(-gap * s) / gap) : decay * s;
}

Propagator propagate_weak(double a, double g, double s) noexcept {
    const double x = a * g;
    const double fall = std::expm1(-s / a);
    const double g_end = g * std::exp(-s / a);
    double psi = 0;
    double chi = 0;
    double coefficient = 1;
    double integral = divided_difference(1, 0, s);
    for (int k = 0; k < 24; ++k) {
        const double next = divided_difference(1, (k + 1) / a, s);
        psi += coefficient * integral;
        chi += coefficient * next;
        coefficient *= -x / (k + 1);
        integral = next;
        if (std::abs(coefficient) < 1e-18) break;
    }
    const double scale = std::exp(a * g_end);
    return {std::exp(-s + x * fall), scale * psi, scale * g * chi, g_end};
}

// For larger a·g both integrands are analytic and fall off backwards from the end of the interval. Where the
// exponent exceeds 50 they are negligible. On the rest, at most 4.6 units of a, Gauss–Legendre quadrature
// converges geometrically.
constexpr double visible = 50;
constexpr double panels[] = {0, 0.22, 0.5, 1};

Propagator propagate_strong(double a, double g, double s) noexcept {
    using Rule = boost::math::quadrature::gauss<double, 20>;
    const double g_end = g * std::exp(-s / a);
    const double x_end = a * g_end;
    const double stretch = std::min({s, a * std::log1p(visible / x_end), visible / (1 + g_end)});
    double psi = 0;
    double chi = 0;
    const auto add = [&](double u, double weight) {
        const double growth = std::expm1(u / a);
        const double value = weight * std::exp(-u - x_end * growth);
        psi += value;
        chi += value * (1 + growth);
    };
    for (int panel = 0; panel < 3; ++panel) {
        const double half = 0.5 * (panels[panel + 1] - panels[panel]) * stretch;
        const double middle = 0.5 * (panels[panel + 1] + panels[panel]) * stretch;
        for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
            add(middle - half * Rule::abscissa()[i], half * Rule::weights()[i]);
            add(middle + half * Rule::abscissa()[i], half * Rule::weights()[i]);
        }
    }
    return {std::exp(-s + a * g * std::expm1(-s / a)), psi, chi * g_end, g_end};
}

}  // namespace

Propagator propagate(double a, double g, double s) noexcept {
    const double x = a * g;
    if (x <= weak) return propagate_weak(a, g, s);
    const double strong_for = a * std::log(x / weak);
    if (s <= strong_for) return propagate_strong(a, g, s);
    const Propagator first = propagate_strong(a, g, strong_for);
    const Propagator second = propagate_weak(a, first.g, s - strong_for);
    return {first.phi * second.phi, first.psi * second.phi + second.psi, first.chi * second.phi + second.chi,
            second.g};
}

}  // namespace afferent
