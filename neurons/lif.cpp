#include "afferent/neurons/lif.hpp"

#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

const LifParameters& without_adaptation(const LifParameters& parameters) {
    parameters.check();
    require(parameters.delta_g == 0, "delta_g", "0 for a neuron without adaptation", parameters.delta_g);
    require(parameters.refractory_ms == 0, "refractory_ms", "0 for a neuron without refractory period",
            parameters.refractory_ms);
    return parameters;
}

}  // namespace

Lif::Lif(const LifParameters& parameters) : membrane_(without_adaptation(parameters)) {}

void Lif::advance(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept {
    const double s = membrane_.units(dt);
    const double charge = -expm1(-s);
    const double decay = s < 0.5 ? 1 - charge : std::exp(-s);
    state.gap_mv = state.gap_mv * decay - membrane_.excess_mv(drive_mv) * charge;
}

Interval Lif::next_spike(const State& state, double drive_mv) const noexcept {
    if (state.gap_mv <= 0) return Interval(0);
    const double excess_mv = membrane_.excess_mv(drive_mv);
    if (excess_mv <= 0) return never;
    return membrane_.interval(std::log1p(state.gap_mv / excess_mv));
}

}  // namespace afferent
