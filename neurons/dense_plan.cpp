#include "afferent/neurons/dense_plan.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent::dense {
namespace {

// The terms of a crossing's series exceed their sum by up to e^(this), and as many digits are lost.
constexpr double most_growth = 5;
// The longest step, in units of tau_g, for which the terms of the series fall off.
constexpr double longest_in_tau_g = 0.28;
// The g that so many spikes at once would leave is the largest at usual rates.
constexpr double usual_spikes = 8;
// The levels of Model, as parts of the largest growth that occurs.
constexpr std::array level_parts{0.14, 0.21, 0.3, 0.5, 1.0};

// The number of terms beyond which none changes the sum, for conductances up to g_limit and times up to
// `fall` by which z grows by at most e^growth.
std::size_t terms_for(double a, double fall, double g_limit, double growth) {
    std::size_t needed = 8;
    for (int part = 1; part <= 16; ++part) {
        const double epsilon = std::max(fall, -growth / a) * part / 16;
        const double most = std::min(a * g_limit, growth / -epsilon - a);
        for (const double x : {0.0, 0.5 * most, most}) {
            // The series for z = W = 1 and a drive that overcomes the conductance.
            double before = 1;
            double term = epsilon * ((a + x) - x + a * (1 + x / a));
            for (std::size_t n = 1; n + 1 < 2 * max_terms; ++n) {
                const double count = static_cast<double>(n);
                double next = epsilon * (a + x - count) * term + epsilon * epsilon * x * before;
                if (n == 1) next -= epsilon * epsilon * x;
                before = term;
                term = next / (count + 1);
                if (std::abs(term) > 2e-16) needed = std::max(needed, n + 2);
            }
        }
    }
    return needed;
}

// With the fewest coefficients that hold g up to `usual`, over as much as they hold.
std::optional<IntervalPolynomials> near_polynomials(double a, double step, double g_max, double usual) {
    for (const int count : near_counts) {
        const double least = count == near_counts.back() ? 1e-3 * g_max : std::min(usual, g_max);
        for (double near_max = g_max; near_max >= least; near_max *= 0.8)
            if (auto fit = IntervalPolynomials::fit(a, step, near_max, count)) return fit;
    }
    return std::nullopt;
}

// 2 atanh(y) = log1p(ε), to the last digit within the step.
void set_log_terms(Model& model) {
    const double y = model.fall / (2 + model.fall);
    double power = 1;
    for (model.log_count = 0; model.log_count < model.log_terms.size() && power > 1e-17; power *= y * y) {
        const auto n = model.log_count++;
        model.log_terms[n] = -2 * model.a / (2 * static_cast<double>(n) + 1);
    }
}

// Before a spike g W is below the drive's excess. So this covers an excess of three to four times W, and the
// first spikes of a strong adaptation; AdaptingLif computes what is beyond.
double usual_g_max(double delta_g) { return 3 + 4 * delta_g; }

// More is left to AdaptingLif where the series does not hold.
constexpr double most_held_g = 4096;

// The longest step for which the series holds with conductances up to g_limit.
double longest_step(double a, double g_limit) {
    return std::min(longest_in_tau_g * a, most_growth / (1 + g_limit));
}

void cut(Plan& plan, double scan_interval, int steps) {
    plan.steps = steps;
    plan.model.step = scan_interval / steps;
    plan.model.decay = std::exp(-plan.model.step);
    plan.model.fall = std::expm1(-plan.model.step / plan.model.a);
}

// False if they do not hold conductances up to g_max.
bool set_polynomials(Model& model, double g_max, double delta_g) {
    const auto far = IntervalPolynomials::fit(model.a, model.step, g_max);
    if (!far) return false;
    const auto near = near_polynomials(model.a, model.step, g_max, usual_spikes * delta_g);
    if (!near) return false;
    model.far = *far;
    model.near = *near;
    return true;
}

// False if it takes too many terms.
bool set_series(Model& model, double g_limit) {
    model.g_limit = g_limit;
    const double largest = -model.fall * model.a * (1 + g_limit);
    for (std::size_t i = 0; i < model.levels.size(); ++i) {
        const double growth = largest * level_parts[i];
        model.levels[i] = {growth, terms_for(model.a, model.fall, g_limit, growth)};
    }
    set_log_terms(model);
    // Where rounding of z could move the crossing by a tenth of a nanosecond.
    const double noise = 4 * std::numeric_limits<double>::epsilon() * std::exp((1 + g_limit) * model.step);
    model.graze = 10 * noise * model.a * model.tau_ns;
    return model.levels.back().terms <= max_terms;
}

}  // namespace

LifParameters planned(LifParameters parameters) {
    parameters.refractory_ms = 0;
    parameters.v_th_mv = std::max(parameters.v_r_mv, parameters.e_k_mv) + 1;
    const double rounded_up = std::exp2(std::ceil(4 * std::log2(parameters.delta_g)) / 4);
    if (parameters.delta_g > 0 && std::isfinite(rounded_up)) parameters.delta_g = rounded_up;
    return parameters;
}

int steps_class(const LifParameters& parameters, Duration scan_interval) {
    const LifParameters of = planned(parameters);
    if (of.delta_g == 0) return 1;
    const double longest = longest_step(of.tau_g_ms / of.tau_m_ms, usual_g_max(of.delta_g) + of.delta_g);
    const double steps = std::ceil(Milliseconds(scan_interval).count() / of.tau_m_ms / longest);
    if (!(steps <= most_steps)) return 2 * most_steps;
    return std::min(most_steps, static_cast<int>(std::bit_ceil(static_cast<unsigned>(steps))));
}

void check(const LifParameters& parameters, Duration scan_interval) {
    parameters.check();
    const double scan_interval_ms = Milliseconds(scan_interval).count();
    require(scan_interval > Duration(0), "scan_interval_ms", "> 0", scan_interval_ms);
    require(scan_interval_ms <= 4000, "scan_interval_ms", "at most 4000 for the dense form",
            scan_interval_ms);
}

Plan plan(const LifParameters& parameters, Duration scan_interval) {
    check(parameters, scan_interval);
    Plan result{};
    Model& model = result.model;
    model.adapts = parameters.delta_g > 0;
    model.tau_ns = Interval(Milliseconds(parameters.tau_m_ms)).count();
    model.a = parameters.tau_g_ms / parameters.tau_m_ms;
    model.v_r_mv = parameters.v_r_mv;
    model.e_k_mv = parameters.e_k_mv;
    const double interval = Milliseconds(scan_interval).count() / parameters.tau_m_ms;
    result.series = true;
    cut(result, interval, 1);
    if (!model.adapts) return result;

    const double delta_g = parameters.delta_g;
    const double g_max = usual_g_max(delta_g);
    const double fewest = std::ceil(interval / longest_step(model.a, g_max + delta_g));
    if (fewest <= most_steps)
        for (int steps = static_cast<int>(fewest); steps <= most_steps; ++steps) {
            cut(result, interval, steps);
            if (set_series(model, g_max + delta_g) && set_polynomials(model, g_max, delta_g)) return result;
        }
    // Too stiff for the series. The polynomials still tell who does not fire, of the neurons whose g they
    // hold.
    result.series = false;
    cut(result, interval, 1);
    for (double held = std::min(g_max, most_held_g); held > 1e-3; held /= 2)
        if (set_polynomials(model, held, delta_g)) return result;
    // No polynomial holds: every conductance is beyond these.
    model.near.count = model.far.count = near_counts.front();
    model.near.g_max = model.far.g_max = -1;
    return result;
}

}  // namespace afferent::dense
