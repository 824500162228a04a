#include "afferent/neurons/adapting_lif.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/neurons/propagator.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

const NeuronParameters& checked(const NeuronParameters& parameters) {
    parameters.check();
    require(parameters.refractory_ms == 0, "refractory_ms", "0 for a neuron without refractory period",
            parameters.refractory_ms);
    return parameters;
}

}  // namespace

AdaptingLif::AdaptingLif(const NeuronParameters& parameters)
    : membrane_(checked(parameters)),
      a_(parameters.tau_g_ms / parameters.tau_m_ms),
      reversal_mv_(parameters.v_th_mv - parameters.e_k_mv),
      delta_g_(parameters.delta_g) {}

void AdaptingLif::advance(State& state, double drive_mv, Interval dt) const noexcept {
    const Propagator flow = propagate(a_, state.g, membrane_.units(dt));
    state = {state.gap_mv * flow.phi - membrane_.excess_mv(drive_mv) * flow.psi + reversal_mv_ * flow.chi,
             flow.g};
}

void AdaptingLif::hold(State& state, Interval dt) const noexcept {
    state.g *= std::exp(-membrane_.units(dt) / a_);
}

Interval AdaptingLif::next_spike(const State& state, double drive_mv) const noexcept {
    if (state.gap_mv <= 0) return Interval(0);
    const double excess_mv = membrane_.excess_mv(drive_mv);
    if (excess_mv <= 0) return never;
    return membrane_.interval(crossing(state.gap_mv, state.g, excess_mv));
}

Interval AdaptingLif::earliest_spike(const State& state, double drive_mv) const noexcept {
    if (state.gap_mv <= 0) return Interval(0);
    const double excess_mv = membrane_.excess_mv(drive_mv);
    if (excess_mv <= 0) return never;
    return membrane_.interval(bound(state.gap_mv, excess_mv));
}

// Without its conductance the membrane rises faster wherever v > E_k, and below E_k it is farther from
// threshold than at E_k.
double AdaptingLif::bound(double gap_mv, double excess_mv) const noexcept {
    return std::log1p(std::min(gap_mv, reversal_mv_) / excess_mv);
}

// The root of z, which is positive before it and negative after it. With the conductance frozen at the value
// it has at the current point, the remaining time has a closed form; g decays, so from the left it is a
// little late and the steps converge at least as fast as Newton's. Steps that leave the bracket, or that a
// conductance too high for the drive forbids, are halvings of the bracket.
double AdaptingLif::crossing(double gap_mv, double g, double excess_mv) const noexcept {
    double low = 0;
    double high = std::numeric_limits<double>::infinity();
    double s = bound(gap_mv, excess_mv);
    for (;;) {
        const Propagator flow = propagate(a_, g, s);
        const double up = excess_mv * flow.psi;
        const double down = gap_mv * flow.phi + reversal_mv_ * flow.chi;
        const double gap = down - up;
        (gap > 0 ? low : high) = s;

        const double rise_mv = excess_mv - flow.g * reversal_mv_;  // dv/ds at threshold
        const double rate = 1 + flow.g;
        const double ratio = rate * gap / rise_mv;
        if (rise_mv > 0 && ratio > -1) {
            const double step = std::log1p(ratio) / rate;
            const double next = s + step;
            const bool settled = std::abs(gap) <= 2 * epsilon * (up + down) || std::abs(step) <= epsilon * s;
            if (settled) return std::max(next, 0.0);
            if (next > low && next < high) {
                s = next;
                continue;
            }
        }
        if (high < std::numeric_limits<double>::infinity()) {
            const double middle = low + 0.5 * (high - low);
            if (middle <= low || middle >= high) return high;
            s = middle;
        } else {
            // Wait until the drive overcomes the conductance twice over.
            s += std::max(a_ * std::log(2 * flow.g * reversal_mv_ / excess_mv), epsilon * s);
        }
    }
}

}  // namespace afferent
