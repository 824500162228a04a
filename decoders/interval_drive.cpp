#include "afferent/decoders/interval_drive.hpp"

#include <cmath>
#include <limits>
#include <variant>

#include "afferent/neurons/propagator.hpp"

namespace afferent {
namespace {

const LifParameters& lif_of(const LifParameters& lif) { return lif; }
const LifParameters& lif_of(const FixedPointParameters& fixed_point) { return fixed_point.lif; }

}  // namespace

IntervalDrive::IntervalDrive(const NeuronModel& model)
    : lif_(std::visit([](const auto& parameters) { return lif_of(parameters); }, model)) {}

double IntervalDrive::excess_mv(double g, Duration interval) const noexcept {
    const double rising_ms = Milliseconds(interval).count() - lif_.refractory_ms;
    if (!(rising_ms > 0)) return std::numeric_limits<double>::infinity();
    const Propagator flow =
        propagate(lif_.tau_g_ms / lif_.tau_m_ms, g * std::exp(-lif_.refractory_ms / lif_.tau_g_ms),
                  rising_ms / lif_.tau_m_ms);
    return (lif_.rheobase_mv() * flow.phi + excess_per_g_mv() * flow.chi) / flow.psi;
}

// As if g had been all the time what it is at the end:
//     ∫₀ˢ u e^(−(1+g)u) du / ∫₀ˢ e^(−(1+g)u) du
double IntervalDrive::delay_s(double g, Duration interval) const noexcept {
    const double s = (Milliseconds(interval).count() - lif_.refractory_ms) / lif_.tau_m_ms;
    if (!(s > 0)) return 0;
    const double leak = 1 + decayed(g, interval);
    const double x = leak * s;
    // x → 0: half of the interval.
    const double mean = x < 1e-6 ? s / 2 : 1 / leak - s / std::expm1(x);
    return mean * tau_m_s();
}

// From the derivative of the equation above at its root, −(c − g W)/Ψ, with g as in delay_s().
double IntervalDrive::excess_per_s_mv(double excess_mv, double g, Duration interval) const noexcept {
    const double s = (Milliseconds(interval).count() - lif_.refractory_ms) / lif_.tau_m_ms;
    if (!(s > 0)) return 0;
    const double g_end = decayed(g, interval);
    const double psi = -std::expm1(-(1 + g_end) * s) / (1 + g_end);
    return (excess_mv - g_end * excess_per_g_mv()) / (psi * tau_m_s());
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
