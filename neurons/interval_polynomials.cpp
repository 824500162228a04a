#include "afferent/neurons/interval_polynomials.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/neurons/propagator.hpp"

namespace afferent {
namespace {

struct Pair {
    double phi;
    double chi;
};

// X/g has a limit at g = 0, which it has reached at 1e-30.
Pair solution(double a, double interval, double g) {
    g = std::max(g, 1e-30);
    const Propagator flow = propagate(a, g, interval);
    return {flow.phi, flow.chi / g};
}

double value(const std::array<double, IntervalPolynomials::most>& coefficients, int count, double u) {
    double sum = 0;
    for (int k = count - 1; k >= 0; --k) sum = sum * u + coefficients[static_cast<std::size_t>(k)];
    return sum;
}

// Interpolation in Chebyshev points, expanded in powers of u. That is well conditioned here, because the
// coefficients fall off fast.
IntervalPolynomials interpolate(double a, double interval, double g_max, int count) {
    IntervalPolynomials fit{g_max, count, {}, {}};
    std::array<Pair, IntervalPolynomials::most> samples;
    const auto n = static_cast<std::size_t>(count);
    const auto angle = [&](std::size_t j) {
        return std::numbers::pi * (static_cast<double>(j) + 0.5) / count;
    };
    for (std::size_t j = 0; j < n; ++j)
        samples[j] = solution(a, interval, 0.5 * g_max * (1 + std::cos(angle(j))));

    std::array<double, IntervalPolynomials::most> before{};   // T_(k−1) as powers of u
    std::array<double, IntervalPolynomials::most> current{};  // T_k
    current[0] = 1;
    for (std::size_t k = 0; k < n; ++k) {
        Pair weight{};
        for (std::size_t j = 0; j < n; ++j) {
            const double cosine = std::cos(static_cast<double>(k) * angle(j)) * (k == 0 ? 1 : 2) / count;
            weight.phi += samples[j].phi * cosine;
            weight.chi += samples[j].chi * cosine;
        }
        for (std::size_t i = 0; i <= k; ++i) {
            fit.phi[i] += weight.phi * current[i];
            fit.chi[i] += weight.chi * current[i];
        }
        std::array<double, IntervalPolynomials::most> next{};
        for (std::size_t i = 0; i + 1 < next.size(); ++i) next[i + 1] = (k == 0 ? 1 : 2) * current[i];
        if (k > 0)
            for (std::size_t i = 0; i < next.size(); ++i) next[i] -= before[i];
        before = current;
        current = next;
    }
    return fit;
}

double worst_error(const IntervalPolynomials& fit, double a, double interval) {
    double worst = 0;
    const int points = 4 * fit.count + 1;
    for (int i = 0; i <= points; ++i) {
        const double g = fit.g_max * i / points;
        const Pair exact = solution(a, interval, g);
        const double u = 2 * g / fit.g_max - 1;
        worst =
            std::max({worst, std::abs(value(fit.phi, fit.count, u) - exact.phi) / (exact.phi + g * exact.chi),
                      std::abs(value(fit.chi, fit.count, u) / exact.chi - 1)});
    }
    return worst;
}

}  // namespace

std::optional<IntervalPolynomials> IntervalPolynomials::fit(double a, double interval, double g_max,
                                                            int count) {
    const IntervalPolynomials polynomials = interpolate(a, interval, g_max, count);
    if (worst_error(polynomials, a, interval) <= tolerance) return polynomials;
    return std::nullopt;
}

std::optional<IntervalPolynomials> IntervalPolynomials::fit(double a, double interval, double g_max) {
    for (int count = 8; count <= most; count += 2)
        if (const auto polynomials = fit(a, interval, g_max, count)) return polynomials;
    return std::nullopt;
}

}  // namespace afferent
