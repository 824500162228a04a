#include "afferent/decoders/interval_drive.hpp"

#include <cmath>
#include <limits>
#include <variant>

namespace afferent {
namespace {

const LifParameters& own_lif(const LifParameters& lif) { return lif; }
const LifParameters& own_lif(const FixedPointParameters& fixed_point) { return fixed_point.lif; }

}  // namespace

const LifParameters& lif_of(const NeuronModel& model) noexcept {
    return std::visit([](const auto& parameters) -> const LifParameters& { return own_lif(parameters); },
                      model);
}

IntervalDrive::IntervalDrive(const NeuronModel& model)
    : lif_(lif_of(model)), table_(IntervalTable::shared(lif_.tau_g_ms / lif_.tau_m_ms)) {}

// The derivative is that of the equation above at its root, −(c − g W)/(Ψ tau_m), and 1/Ψ = 1 + phi + chi.
// The mean lies where it would if g had always been what it is at the end:
//     ∫₀ˢ u e^(−(1+g)u) du / ∫₀ˢ e^(−(1+g)u) du = (1 − s Φ/Ψ)/(1 + g)
IntervalDrive::Solution IntervalDrive::solve(double g, Duration interval) const noexcept {
    const double rising_ms = Milliseconds(interval).count() - lif_.refractory_ms;
    const double kept = decayed(1, interval);
    if (!(rising_ms > 0)) return {std::numeric_limits<double>::infinity(), 0, 0, kept};
    const double g_end = g * kept;
    const double s = rising_ms / lif_.tau_m_ms;
    const auto [phi, chi] = (*table_)(s, g_end);
    const double excess_mv = lif_.rheobase_mv() * phi + excess_per_g_mv() * chi;
    return {excess_mv, (excess_mv - g_end * excess_per_g_mv()) * (1 + phi + chi) / tau_m_s(),
            (1 - s * phi) / (1 + g_end) * tau_m_s(), kept};
}

double IntervalDrive::least_excess_mv() const noexcept { return lif_.rheobase_mv() / std::expm1(5.0); }

double IntervalDrive::decayed(double g, Duration time) const noexcept {
    return g * std::exp(-Milliseconds(time).count() / lif_.tau_g_ms);
}

double IntervalDrive::driven(double g, Duration time, double rate_hz) const noexcept {
    const double fall = std::expm1(-Milliseconds(time).count() / lif_.tau_g_ms);
    return g + (g - lif_.delta_g * rate_hz * tau_g_s()) * fall;
}

}  // namespace afferent
