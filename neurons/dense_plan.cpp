#include "afferent/neurons/dense_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent::dense {
namespace {

constexpr int most_steps = 4;
// The terms of a crossing's series exceed their sum by up to e^(this), and as many digits are lost.
constexpr double most_growth = 5;
// The longest step, in units of tau_g, for which the terms of the series fall off.
constexpr double longest_in_tau_g = 0.28;

// The number of terms, a multiple of four, beyond which none changes the sum, for conductances up to g_limit.
std::size_t terms_for(double a, double step, double g_limit) {
    const double fall = std::expm1(-step / a);
    std::size_t needed = 8;
    for (int i = 0; i <= 64; ++i) {
        const double x = a * g_limit * i / 64;
        // The series for z = W = 1 and a drive that overcomes the conductance.
        double before = 1;
        double term = fall * ((a + x) - x + a * (1 + g_limit));
        for (std::size_t n = 1; n + 1 < 2 * max_terms; ++n) {
            const double count = static_cast<double>(n);
            double next = fall * (a + x - count) * term + fall * fall * x * before;
            if (n == 1) next -= fall * fall * x;
            before = term;
            term = next / (count + 1);
            if (std::abs(term) > 1e-15) needed = std::max(needed, n + 2);
        }
    }
    return (needed + 3) / 4 * 4;
}

}  // namespace

Plan plan(const LifParameters& parameters, Duration scan_interval) {
    parameters.check();
    const double scan_interval_ms = Milliseconds(scan_interval).count();
    require(scan_interval > Duration(0), "scan_interval_ms", "> 0", scan_interval_ms);
    require(scan_interval_ms <= 4000, "scan_interval_ms", "at most 4000 for the dense form",
            scan_interval_ms);

    Plan result{};
    Model& model = result.model;
    model.adapts = parameters.delta_g > 0;
    model.tau_ns = Interval(Milliseconds(parameters.tau_m_ms)).count();
    model.a = parameters.tau_g_ms / parameters.tau_m_ms;
    model.v_r_mv = parameters.v_r_mv;
    model.e_k_mv = parameters.e_k_mv;
    model.v_th_mv = parameters.v_th_mv;
    model.delta_g = parameters.delta_g;
    const double scan_interval_units = scan_interval_ms / parameters.tau_m_ms;
    const auto cut = [&](int steps) {
        result.steps = steps;
        model.step = scan_interval_units / steps;
        model.decay = std::exp(-model.step);
        model.fall = std::expm1(-model.step / model.a);
    };
    cut(1);
    if (!model.adapts) return result;

    // Before a spike g W is below the drive's excess. So this covers an excess of three to four times W, and
    // the first spikes of a strong adaptation; AdaptingLif computes what is beyond.
    const double g_max = 3 + 4 * parameters.delta_g;
    model.g_limit = g_max + parameters.delta_g;
    const double longest = std::min(longest_in_tau_g * model.a, most_growth / (1 + model.g_limit));
    const auto refuse = [&](double units) {
        throw ParameterError("scan_interval_ms",
                             "at most " + std::to_string(units * parameters.tau_m_ms) +
                                 " for the dense form, with this adaptation",
                             std::to_string(scan_interval_ms));
    };
    if (scan_interval_units > most_steps * longest) refuse(most_steps * longest);
    for (int steps = static_cast<int>(std::ceil(scan_interval_units / longest)); steps <= most_steps;
         ++steps) {
        cut(steps);
        const auto fit = IntervalPolynomials::fit(model.a, model.step, g_max);
        model.terms = terms_for(model.a, model.step, model.g_limit);
        if (!fit || model.terms > max_terms) continue;
        model.polynomials = *fit;
        // Where rounding of z could move the crossing by a tenth of a nanosecond.
        const double noise =
            4 * std::numeric_limits<double>::epsilon() * std::exp((1 + model.g_limit) * model.step);
        model.graze = 10 * noise * model.a * model.tau_ns;
        return result;
    }
    refuse(longest);
    return result;
}

}  // namespace afferent::dense
