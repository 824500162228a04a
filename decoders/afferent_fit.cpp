#include "afferent/decoders/afferent_fit.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "afferent/neurons/propagator.hpp"
#include "afferent/runtime/piecewise_linear.hpp"

namespace afferent {
namespace {

// Further back than so many tau_m, weights are below 1e-6 of the last.
constexpr double longest_memory = 14;
constexpr int search_steps = 64;

// By the trapezoid rule with the weights exp(−u − a g expm1(u/a)), u in units of tau_m before the end, where
// the conductance is g.
double weighed_force_n(const LifParameters& lif, double g, double length, double end_s,
                       const ForceTrace& force) {
    const double a = lif.tau_g_ms / lif.tau_m_ms;
    const double step = std::min(length, longest_memory) / search_steps;
    double weights = 0;
    double sum = 0;
    for (int i = 0; i <= search_steps; ++i) {
        const double u = step * i;
        const double weight =
            std::exp(-u - a * g * std::expm1(u / a)) * (i == 0 || i == search_steps ? 0.5 : 1.0);
        weights += weight;
        sum += weight * force_n_at(force, end_s - u * lif.tau_m_ms * 1e-3);
    }
    return sum / weights;
}

const LifParameters& approximated(const LifParameters& lif) { return lif; }
const LifParameters& approximated(const FixedPointParameters& chip) { return chip.lif; }

}  // namespace

double force_n_at(const ForceTrace& trace, double time_s) noexcept {
    return interpolate(trace, &ForcePoint::time_s, &ForcePoint::force_n, time_s);
}

std::vector<DriveSample> drive_samples(const NeuronModel& neuron, std::span<const TimePoint> spikes,
                                       const ForceTrace& force, Duration delay) {
    const LifParameters& lif = std::visit(
        [](const auto& parameters) -> const LifParameters& { return approximated(parameters); }, neuron);
    std::vector<DriveSample> samples;
    double g = 0;
    for (std::size_t i = 0; i < spikes.size(); ++i) {
        const double interval_ms = i > 0 ? Milliseconds(spikes[i] - spikes[i - 1]).count() : 0;
        const double rising = (interval_ms - lif.refractory_ms) / lif.tau_m_ms;
        if (i > 0 && rising > 0) {
            const Propagator flow = propagate(lif.tau_g_ms / lif.tau_m_ms,
                                              g * std::exp(-lif.refractory_ms / lif.tau_g_ms), rising);
            const double excess_mv =
                (lif.rheobase_mv() * flow.phi + (lif.v_th_mv - lif.e_k_mv) * flow.chi) / flow.psi;
            samples.push_back({weighed_force_n(lif, flow.g, rising, seconds(spikes[i] - delay), force),
                               excess_mv + lif.rheobase_mv()});
        }
        g = g * std::exp(-interval_ms / lif.tau_g_ms) + lif.delta_g;
    }
    return samples;
}

std::optional<DriveFit> fit_drive(std::span<const DriveSample> samples) noexcept {
    const auto count = static_cast<double>(samples.size());
    if (samples.size() < 3) return std::nullopt;
    double force_n = 0;
    double drive_mv = 0;
    for (const DriveSample& sample : samples) {
        force_n += sample.force_n / count;
        drive_mv += sample.drive_mv / count;
    }
    double ff = 0;
    double fd = 0;
    double dd = 0;
    for (const DriveSample& sample : samples) {
        const double f = sample.force_n - force_n;
        const double d = sample.drive_mv - drive_mv;
        ff += f * f;
        fd += f * d;
        dd += d * d;
    }
    // Forces that differ by no more than rounding fix no slope.
    if (!(ff > 1e-18 * count * (1 + force_n * force_n))) return std::nullopt;
    const double gain = fd / ff;
    return DriveFit{gain, drive_mv - gain * force_n, std::sqrt(std::max(0.0, dd - gain * fd) / count),
                    samples.size()};
}

}  // namespace afferent
