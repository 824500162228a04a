#include "afferent/neurons/lif_models.hpp"

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>

#include "afferent/neurons/propagator.hpp"

namespace afferent {
namespace {

// g at the end of the refractory period, after one spike (onset) or after spikes every `interval_ms` for good
// (steady).
//
//     steady: g just after a spike is the fixed point of  g → g e^(−T/tau_g) + Δg
double g_after_spike(RateKind kind, const LifParameters& p, double interval_ms) {
    const double after_spike =
        kind == RateKind::steady ? p.delta_g / -std::expm1(-interval_ms / p.tau_g_ms) : p.delta_g;
    return after_spike * std::exp(-p.refractory_ms / p.tau_g_ms);
}

}  // namespace

double lif_rate_hz(RateKind kind, const LifParameters& parameters, double drive_mv) {
    LifParameters membrane = parameters;
    membrane.refractory_ms = 0;
    const AdaptingLif neuron(membrane);
    // The next interval, if g is what intervals of this length lead to.
    const auto next_ms = [&](double interval_ms) {
        AdaptingLif::State state = neuron.rest();
        state.g = g_after_spike(kind, parameters, interval_ms);
        return parameters.refractory_ms + Milliseconds(neuron.next_spike(state, drive_mv)).count();
    };
    // After longer intervals less g is left, so the next one is shorter: this function falls, and it has one
    // fixed point, between the interval without any g and the one that follows it.
    const double shortest = next_ms(std::numeric_limits<double>::infinity());
    if (!std::isfinite(shortest)) return 0;
    if (kind == RateKind::onset || parameters.delta_g == 0) return 1000 / shortest;
    const double longest = next_ms(shortest);
    if (!(longest > shortest)) return 1000 / shortest;
    // Where almost nothing is left of g, rounding may put the fixed point at the very end.
    if (!(next_ms(longest) < longest)) return 1000 / longest;
    std::uintmax_t iterations = 200;
    const auto [low, high] = boost::math::tools::toms748_solve(
        [&](double interval_ms) { return next_ms(interval_ms) - interval_ms; }, shortest, longest,
        boost::math::tools::eps_tolerance<double>(50), iterations);
    return 1000 / ((low + high) / 2);
}

// With the gap z to threshold, excess drive c and W = v_th − E_k (neurons/membrane.hpp): z falls from the
// reset to 0 in the interval where  0 = z_reset Φ − c Ψ + W X.
double lif_drive_mv(const LifParameters& p, const std::optional<Propagator>& flow) {
    if (!flow) return std::numeric_limits<double>::infinity();
    const double reset_gap = p.v_th_mv - p.v_r_mv;
    return reset_gap + (reset_gap * flow->phi + (p.v_th_mv - p.e_k_mv) * flow->chi) / flow->psi;
}

std::optional<Propagator> lif_flow(RateKind kind, const LifParameters& p, double rate_hz) {
    const double interval_ms = 1000 / rate_hz;
    if (!(interval_ms > p.refractory_ms)) return std::nullopt;
    return propagate(p.tau_g_ms / p.tau_m_ms, g_after_spike(kind, p, interval_ms),
                     (interval_ms - p.refractory_ms) / p.tau_m_ms);
}

bool flow_alike(const LifParameters& one, const LifParameters& other) noexcept {
    return one.tau_m_ms == other.tau_m_ms && one.tau_g_ms == other.tau_g_ms && one.delta_g == other.delta_g &&
           one.refractory_ms == other.refractory_ms;
}

double lif_drive_mv(RateKind kind, const LifParameters& parameters, double rate_hz) {
    return lif_drive_mv(parameters, lif_flow(kind, parameters, rate_hz));
}

// Conductance delays every spike while v > E_k, but where the reset is below E_k it also pulls v up, to E_k
// at most. So no interval is shorter than the one without conductance from the higher of v_r and E_k.
double highest_rate_hz(const LifParameters& parameters, double drive_mv) {
    LifParameters fastest = parameters.with_adaptation(0);
    if (parameters.delta_g > 0 && parameters.e_k_mv > parameters.v_r_mv) {
        fastest.v_r_mv = parameters.e_k_mv;
        drive_mv += parameters.v_r_mv - parameters.e_k_mv;
    }
    return lif_rate_hz(RateKind::onset, fastest, drive_mv);
}

std::variant<Lif, Refractory<Lif>, AdaptingLif, Refractory<AdaptingLif>> smallest_neuron(
    const LifParameters& parameters) {
    parameters.check();
    const bool adapts = parameters.delta_g > 0;
    const bool rests = parameters.refractory_ms > 0;
    if (adapts && rests) return Refractory<AdaptingLif>(parameters);
    if (adapts) return AdaptingLif(parameters);
    if (rests) return Refractory<Lif>(parameters);
    return Lif(parameters);
}

}  // namespace afferent
