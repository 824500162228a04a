#include "bench/sampled_force.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

// The least standard deviation that the belief states.
constexpr double least_sigma_n = 1e-3;
// How often the absence of a change is taken in. More often, and moment matching would shrink the belief by
// its own error.
constexpr double silence_step_s = 0.02;
constexpr double turned = 3;  // standard deviations from its extreme at which the force has turned

}  // namespace

SampledForce::SampledForce(const TouchedForce& touched)
    : touched_(touched), belief_(touched.afferents.largest_grip_n, {.particles = 100}) {}

double SampledForce::noise_n(double counts) const {
    const auto last = static_cast<double>(touched_.noise_n.size() - 1);
    return touched_.noise_n[static_cast<std::size_t>(std::clamp(counts, 0.0, last))];
}

void SampledForce::pass(double time_s) {
    if (time_s > time_s_) belief_.predict(time_s - time_s_);
    time_s_ = time_s;
}

void SampledForce::settle() {
    belief_.resample();
    const Estimate now = belief_.at(0);
    const double mean_n = now.force_n;
    const double sigma_n = now.sigma_n;
    const double beyond_n = branch_ * (mean_n - extreme_n_);
    const double play_n = touched_.afferents.hysteresis / 2 * std::abs(extreme_n_);
    const bool has_turned = beyond_n < -std::max(turned * sigma_n, play_n);
    if (has_turned) branch_ = -branch_;
    if (has_turned || beyond_n >= 0) extreme_n_ = mean_n;
}

void SampledForce::read(double time_s, std::span<const std::uint16_t> counts) {
    pass(time_s);
    double weight = 0;
    double weighed_n = 0;
    for (std::size_t e = 0; e < counts.size(); ++e) {
        const double share = touched_.share[e];
        if (share == 0) continue;
        const double own = std::pow(share / noise_n(counts[e]), 2);
        weight += own;
        weighed_n += own * counts[e] * touched_.activity.newtons_per_count / share;
    }
    if (weight == 0) return;
    belief_.measure(MotionParticles::force, weighed_n / weight, 1 / weight + least_sigma_n * least_sigma_n);
    settle();
}

void SampledForce::read_changes(double time_s, const SentCounts& sent) {
    bool silent = true;
    for (std::uint32_t e = 0; e < sent.elements(); ++e) silent = silent && !sent.moved(e);
    if (silent && time_s < bounded_s_ + silence_step_s) return;
    bounded_s_ = time_s;
    pass(time_s);
    double low_n = 0;
    double high_n = touched_.afferents.largest_grip_n;
    for (std::uint32_t e = 0; e < sent.elements(); ++e) {
        const double share = touched_.share[e];
        if (share == 0) continue;
        const auto [low, high] = sent.range(e);
        const double newtons = touched_.activity.newtons_per_count / share;
        const double doubt_n = 2 * noise_n(sent.presumed(e)) / share;
        low_n = std::max(low_n, low * newtons - doubt_n);
        high_n = std::min(high_n, high * newtons + doubt_n);
    }
    if (low_n >= high_n) {
        const double middle_n = (low_n + high_n) / 2;
        low_n = middle_n - least_sigma_n;
        high_n = middle_n + least_sigma_n;
    }
    belief_.truncate(MotionParticles::force, low_n, high_n);
    settle();
}

Estimate SampledForce::at(double time_s) const {
    Estimate estimate = belief_.at(time_s - time_s_);
    const double force_n = estimate.force_n;
    const double hysteresis = touched_.afferents.hysteresis;
    estimate.force_n = std::min(force_n / (1 - hysteresis * branch_), touched_.afferents.largest_grip_n);
    estimate.sigma_n = std::hypot(estimate.sigma_n, hysteresis * force_n / 2);
    return estimate;
}

}  // namespace afferent
