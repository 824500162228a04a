#include "bench/spike_particles.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

#include "afferent/neurons/propagator.hpp"
#include "bench/decoding_bench.hpp"

namespace afferent {
namespace {

constexpr std::size_t first_gap = 2;  // behind force and speed
constexpr double unbounded = 1e6;     // in mV and N

std::size_t afferents_of(const TouchedForce& touched) { return touched.afferents.afferents.size(); }

MotionParticles::Options with_gaps(MotionParticles::Options options, std::size_t gaps) {
    options.variables = gaps;
    return options;
}

}  // namespace

SpikeParticles::SpikeParticles(const TouchedForce& touched, Duration tick,
                               const MotionParticles::Options& options)
    : touched_(touched),
      tick_(tick),
      force_(touched.afferents.largest_grip_n, with_gaps(options, afferents_of(touched))),
      threshold_n_(touched.afferents.largest_grip_n) {
    for (const auto& [address, group, share, patch] : touched.afferents.afferents) {
        const DecodedAfferents::Group& alike = touched.afferents.groups[group];
        if (!(alike.drive_mv_per_n > 0)) continue;  // tells of changes
        const auto* lif = std::get_if<LifParameters>(&alike.neuron);
        if (!lif) throw std::runtime_error("the particle filter knows only the exact neuron");
        force_.set(first_gap + membranes_.size(), lif->rheobase_mv());
        threshold_n_ = std::min(threshold_n_, alike.threshold_n());
        membranes_.push_back({address, *lif, alike.drive_mv_per_n, alike.bias_mv, share});
    }
}

// The gap falls by the drive c above the rheobase, which is linear in the force:  z' = Φ z − Ψ c + W X.
void SpikeParticles::advance(std::size_t index, TimePoint to) {
    Membrane& membrane = membranes_[index];
    const LifParameters& neuron = membrane.neuron;
    const TimePoint from = std::max(membrane.time, std::min(membrane.rises, to));
    const double waited_ms = Milliseconds(from - membrane.time).count();
    const double rising_ms = Milliseconds(to - from).count();
    membrane.g *= std::exp(-waited_ms / neuron.tau_g_ms);
    membrane.time = std::max(membrane.time, to);
    if (!(rising_ms > 0)) return;
    const Propagator flow =
        propagate(neuron.tau_g_ms / neuron.tau_m_ms, membrane.g, rising_ms / neuron.tau_m_ms);
    membrane.g = flow.g;
    const double rest_mv = membrane.bias_mv - neuron.rheobase_mv();
    const double per_n = flow.psi * membrane.drive_mv_per_n;
    const double counts = force_.at(0).force_n * membrane.share / touched_.activity.newtons_per_count;
    const auto reading =
        static_cast<std::size_t>(std::clamp(counts, 0.0, static_cast<double>(touched_.noise_n.size() - 1)));
    const double noise_n = touched_.noise_n[reading] / membrane.share;
    force_.drive(first_gap + index, flow.phi, -per_n,
                 flow.chi * (neuron.v_th_mv - neuron.e_k_mv) - flow.psi * rest_mv,
                 std::pow(per_n * noise_n, 2));
}

void SpikeParticles::spike(std::size_t index, TimePoint stamp) {
    // Somewhere in its tick.
    advance(index, stamp + tick_ / 2);
    Membrane& membrane = membranes_[index];
    const LifParameters& neuron = membrane.neuron;
    // At threshold the gap falls by c − g W within tau_m.
    const double base_mv =
        membrane.bias_mv - neuron.rheobase_mv() - membrane.g * (neuron.v_th_mv - neuron.e_k_mv);
    force_.cross_zero(first_gap + index, base_mv, membrane.drive_mv_per_n,
                      Milliseconds(tick_).count() / neuron.tau_m_ms);
    force_.set(first_gap + index, neuron.rheobase_mv());
    force_.resample();
    membrane.g += neuron.delta_g;
    membrane.rises = membrane.time + rounded(Milliseconds(neuron.refractory_ms));
}

void SpikeParticles::observe(TimePoint until, std::span<const Event> events) {
    const Duration interval = touched_.activity.frame_interval;
    auto event = events.begin();
    for (TimePoint end = scan_ + interval; end <= until; end += interval) {
        for (; event != events.end() && event->time < end; ++event) {
            const auto found = std::find_if(membranes_.begin(), membranes_.end(), [&](const Membrane& each) {
                return each.address == event->address;
            });
            if (found != membranes_.end())
                spike(static_cast<std::size_t>(found - membranes_.begin()), event->time);
        }
        for (std::size_t i = 0; i < membranes_.size(); ++i) {
            advance(i, end);
            if (membranes_[i].rises < end) force_.truncate(first_gap + i, 0, unbounded);
        }
        force_.predict(seconds(interval));
        force_.resample();
        scan_ = end;
    }
}

// Below the force at which firing begins silence tells no more: the estimate is 0, as the decoder has it.
Estimate SpikeParticles::at(TimePoint now) const {
    Estimate estimate = force_.at(seconds(now - scan_));
    if (estimate.force_n >= threshold_n_) return estimate;
    estimate.sigma_n = std::hypot(estimate.sigma_n, estimate.force_n, threshold_n_ / 2);
    estimate.force_n = 0;
    return estimate;
}

std::vector<Estimate> follow_by_particles(const TouchedForce& touched, Duration tick, Duration deadline,
                                          const MotionParticles::Options& options) {
    std::vector<Event> events = touched.activity.events;
    for (Event& event : events) event.time -= (event.time - scene_start) % tick;
    std::sort(events.begin(), events.end());
    SpikeParticles particles(touched, tick, options);
    std::vector<Estimate> estimates;
    auto first = events.begin();
    TimePoint known = scene_start;
    for (std::size_t k = 0; k < touched.true_n.size(); ++k) {
        const TimePoint now = scene_start + static_cast<Duration::rep>(k) * Touch::step;
        for (; known + deadline + delivery <= now; known += deadline) {
            const auto last = std::partition_point(
                first, events.end(), [&](const Event& event) { return event.time < known + deadline; });
            particles.observe(known + deadline, {first, last});
            first = last;
        }
        estimates.push_back(particles.at(now));
    }
    return estimates;
}

}  // namespace afferent
