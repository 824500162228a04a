#include "afferent/neurons/adapting_lif.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "afferent/neurons/propagator.hpp"
#include "afferent/neurons/short_interval.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// This many short intervals cost about as much as the general solution, which is evaluated once for an
// interval and several times for a spike.
constexpr int short_steps = 8;
constexpr int short_steps_to_spike = 32;

const LifParameters& without_refractory_period(const LifParameters& parameters) {
    parameters.check();
    require(parameters.refractory_ms == 0, "refractory_ms", "0 for a neuron without refractory period",
            parameters.refractory_ms);
    const double ratio = parameters.tau_g_ms / parameters.tau_m_ms;
    require(ratio >= 1e-12 && ratio <= 1e12, "tau_g_ms", "between 1e-12 and 1e12 of tau_m_ms",
            parameters.tau_g_ms);
    return parameters;
}

}  // namespace

AdaptingLif::AdaptingLif(const LifParameters& parameters)
    : membrane_(without_refractory_period(parameters)),
      a_(parameters.tau_g_ms / parameters.tau_m_ms),
      e_k_mv_(parameters.e_k_mv),
      reversal_mv_(parameters.v_th_mv - parameters.e_k_mv),
      delta_g_(parameters.delta_g),
      horizon_(a_ >= 2 ? 1 : std::numeric_limits<double>::infinity()),
      kept_at_horizon_(std::exp(-horizon_ / a_)) {}

AdaptingLif AdaptingLif::varied(double v_th_mv, double delta_g) const noexcept {
    AdaptingLif result = *this;
    result.membrane_ = membrane_.with_threshold(v_th_mv);
    result.reversal_mv_ = v_th_mv - e_k_mv_;
    result.delta_g_ = delta_g;
    return result;
}

void AdaptingLif::advance(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept {
    [[maybe_unused]] const State before = state;
    flow(state, drive_mv, dt, expm1);
    assert(within_bounds(before, drive_mv, state));
}

// g decays, and z is the mean of z₀, −c and W with the weights Φ, Ψ and X.
bool AdaptingLif::within_bounds(const State& before, double drive_mv, const State& after) const noexcept {
    const double rest = -membrane_.excess_mv(drive_mv);
    const double low = std::min({before.gap_mv, rest, reversal_mv_});
    const double high = std::max({before.gap_mv, rest, reversal_mv_});
    const double rounding = 1e-12 * std::max(std::abs(low), std::abs(high));
    const bool number = !std::isnan(before.gap_mv) && !std::isnan(rest);
    return !number || (after.g >= 0 && after.g <= before.g && after.gap_mv >= low - rounding &&
                       after.gap_mv <= high + rounding);
}

void AdaptingLif::flow(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept {
    const double excess_mv = membrane_.excess_mv(drive_mv);
    const double s = membrane_.units(dt);
    const double longest = ShortInterval::longest(a_, state.g);
    const int steps = s <= longest ? 1 : s <= short_steps * longest ? static_cast<int>(s / longest) + 1 : 0;
    if (steps > 0) {
        const double fall = expm1(-s / (a_ * steps));
        State there = state;
        int step = 0;
        for (; step < steps; ++step) {
            const ShortInterval interval(a_, reversal_mv_, there.gap_mv, there.g, excess_mv, fall);
            if (!interval.converged()) break;
            there = {interval.end_mv(), there.g + there.g * fall};
        }
        if (step == steps) {
            state = there;
            return;
        }
    }
    const Propagator whole = propagate(a_, state.g, s);
    state = {state.gap_mv * whole.phi - excess_mv * whole.psi + reversal_mv_ * whole.chi, whole.g};
}

void AdaptingLif::hold(State& state, Interval dt) const noexcept {
    state.g *= std::exp(-membrane_.units(dt) / a_);
}

Interval AdaptingLif::next_spike(const State& state, double drive_mv) const noexcept {
    if (state.gap_mv <= 0) return Interval(0);
    const double excess_mv = membrane_.excess_mv(drive_mv);
    if (!(excess_mv > 0)) return never;
    return membrane_.interval(crossing(state.gap_mv, state.g, excess_mv));
}

Interval AdaptingLif::earliest_spike(const State& state, double drive_mv) const noexcept {
    if (state.gap_mv <= 0) return Interval(0);
    const double excess_mv = membrane_.excess_mv(drive_mv);
    if (!(excess_mv > 0)) return never;
    // With less conductance the membrane rises faster wherever v > E_k, and a start below E_k is later than
    // one from E_k. With a conductance that does not decay, the time has a closed form.
    const double g = state.g * kept_at_horizon_;
    const double rise_mv = excess_mv - g * reversal_mv_;
    if (rise_mv <= 0) return membrane_.interval(horizon_);
    const double gap_mv = std::min(state.gap_mv, reversal_mv_);
    // log1p(y)/(1 + g) with y = grown/rise. (3y² + 6y)/(y² + 6y + 6) is less, by at most 0.5 % up to y = e
    // − 1.
    const double grown_mv = (1 + g) * gap_mv;
    const double bound =
        3 * gap_mv * (grown_mv + 2 * rise_mv) / (grown_mv * grown_mv + 6 * rise_mv * (grown_mv + rise_mv));
    // False where a square has left the range of a double.
    if (!(bound * (1 + g) <= 3)) return Interval(0);
    return membrane_.interval(std::min(horizon_, bound));
}

// Tries short intervals one after the other. If they do not reach the spike, or their series does not
// converge, the general solution starts from the beginning.
double AdaptingLif::crossing(double gap_mv, double g, double excess_mv) const noexcept {
    double gap_there_mv = gap_mv;
    double g_there = g;
    double passed = 0;
    for (int step = 0; step < short_steps_to_spike; ++step) {
        double length = ShortInterval::longest(a_, g_there);
        // A guess: as if the membrane rose at the speed that it would have at threshold now.
        const double rise_mv = excess_mv - g_there * reversal_mv_;
        if (rise_mv > 0) length = std::min(length, 1.0001 * gap_there_mv / rise_mv);
        const double fall = std::expm1(-length / a_);
        const ShortInterval interval(a_, reversal_mv_, gap_there_mv, g_there, excess_mv, fall);
        if (!interval.converged()) break;
        if (interval.end_mv() <= 0) return passed - a_ * std::log1p(interval.root());
        passed += length;
        gap_there_mv = interval.end_mv();
        g_there += g_there * fall;
    }
    return far_crossing(gap_mv, g, excess_mv);
}

// The root of z, which is positive before it and negative after it. At the root the drive overcomes the
// conductance, c > g W, which gives one lower bound; the crossing without any conductance gives another.
//
// With the conductance frozen at its value at the current point, the remaining time has a closed form. Where
// z follows the decaying conductance quasi-statically, Newton's step is better. A step that would leave the
// bracket, or is not shorter than half the step before the last, is replaced by halving the bracket.
double AdaptingLif::far_crossing(double gap_mv, double g, double excess_mv) const noexcept {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double low = 0;
    double high = infinity;
    double s = std::max(std::log1p(std::min(gap_mv, reversal_mv_) / excess_mv),
                        a_ * std::log(g * reversal_mv_ / excess_mv));
    double stride = 0;
    double last = infinity;
    double last_but_one = infinity;
    for (;;) {
        const Propagator flow = propagate(a_, g, s);
        const double up = excess_mv * flow.psi;
        const double down = gap_mv * flow.phi + reversal_mv_ * flow.chi;
        const double gap = down - up;
        if (std::isnan(gap)) return infinity;  // the state is NaN
        (gap > 0 ? low : high) = s;

        const double rate = 1 + flow.g;
        const double rise_mv = excess_mv - flow.g * reversal_mv_;  // dv/ds at threshold
        const double ratio = rate * gap / rise_mv;
        double step = infinity;
        if (rise_mv > 0) {
            step = ratio > -0.5 ? std::log1p(ratio) / rate : gap / (rise_mv + rate * gap);
            if (std::abs(gap) <= 2 * epsilon * (up + down) || std::abs(step) <= epsilon * s)
                return std::clamp(s + step, low, high);
        }

        if (high == infinity) {
            stride = stride == 0 ? 1 / rate : 4 * stride;
            step = std::min(step, std::max(stride, epsilon * s));
        } else if (!(s + step > low && s + step < high && std::abs(step) < 0.5 * last_but_one)) {
            step = low + 0.5 * (high - low) - s;
            if (s + step <= low || s + step >= high) return high;
        }
        last_but_one = last;
        last = std::abs(step);
        s += step;
    }
}

}  // namespace afferent
