#include "afferent/decoders/inversion.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/decoders/force_rate_curves.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration rate_time = 40ms;  // time constant of the rate, and of how much is known
// A force may change by these parts of the full scale and of itself from one interval to the next.
constexpr double change_of_full_scale = 0.005;
constexpr double change_of_force = 0.1;
// An interval may miss the full scale by two standard deviations of its measurement, but by no more than
// this.
constexpr double most_slack = 0.1;
// The estimate is saturated if such a part of those that fire is.
constexpr double enough_saturated = 0.75;

}  // namespace

Inversion::Inversion(const Parameters&, const DecodedAfferents& afferents)
    : replay_(afferents),
      largest_n_(afferents.largest_grip_n),
      full_scale_n_(replay_.afferents()),
      full_scale_fraction_(full_scale_fraction(afferents)),
      history_(std::max<Duration>(replay_.history(), 40 * rate_time)),
      rate_(afferents.read(), rate_time, false),
      forces_(replay_.afferents()) {
    for (const auto& afferent : afferents.afferents)
        if (const std::uint32_t index = replay_.index_of(afferent.address); index != SpikeReplay::not_read)
            full_scale_n_[index] = afferents.groups[afferent.group].full_scale_n;
    restart(scene_start);
}

void Inversion::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > heard_until()) lose(heard_until(), begin);
    const TimePoint counted_from = rate_.snapshot().counted_from;
    rate_.observe(begin, end, events);
    for (const auto& [time, address] : events) {
        const std::uint32_t index = replay_.index_of(address);
        if (index == SpikeReplay::not_read || replay_.group_of(index).transient || time < counted_from)
            continue;
        Force& force = forces_[index];
        const SpikeReplay::Expected before =
            replay_.lost_since(index) ? expected(index, time) : SpikeReplay::Expected{force.force_n, 0};
        const SpikeReplay::Spike spike = replay_.hear(index, time, before);
        if (!spike.known) {
            force.force_n = before.force_n;
            continue;
        }
        const double force_n = std::clamp(spike.measured.force_n, 0.0, largest_n_);
        const double full_scale_n = full_scale_n_[index];
        const double measured_sigma_n = std::sqrt(spike.measured.variance_n2);
        const double slack_n = std::min(2 * measured_sigma_n, most_slack * full_scale_n);
        force = {force_n, std::max(std::abs(force_n - force.force_n), measured_sigma_n),
                 spike.measured.force_n + slack_n >= full_scale_fraction_ * full_scale_n,
                 force.solved || measured_sigma_n < SpikeReplay::well_known * force_n};
    }
}

void Inversion::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    rate_.lose(begin, end);
    replay_.lose(begin, end);
}

// The force of the last interval, or as much of it as the silence since allows.
SpikeReplay::Expected Inversion::expected(std::uint32_t index, TimePoint until) const noexcept {
    const double force_n = std::min(forces_[index].force_n, std::max(bound_by_silence(index, until), 0.0));
    const double change_n = change_of_full_scale * full_scale_n_[index] + change_of_force * force_n;
    return {force_n, change_n * change_n};
}

// Just after a loss silence bounds nothing, if a spike was lost. But a silence that is too long for two
// intervals is not one of a force that is held, whatever was lost: then both are weighed.
double Inversion::bound_by_silence(std::uint32_t index, TimePoint until) const noexcept {
    const double bound_n = replay_.silent(index, until).force_n;
    const double lost = std::min(replay_.lost_spikes(index, until), 1.0);
    const SpikeReplay::Train& train = replay_.train(index);
    if (!(lost > 0) || seconds(until - train.last) * train.rate_hz < 2) return bound_n;
    const double none_lost_n = replay_.silent_if_none_lost(index, until).force_n;
    return lost * std::min(bound_n, forces_[index].force_n) + (1 - lost) * std::min(none_lost_n, bound_n);
}

Inversion::Reading Inversion::reading_of(std::uint32_t index, TimePoint until) const noexcept {
    const SpikeReplay::Train& train = replay_.train(index);
    const auto& [drive, threshold_n, n_per_mv, transient] = replay_.group_of(index);
    const auto& [force_n, change_n, saturated, solved] = forces_[index];
    double bound_n = bound_by_silence(index, until);
    // Unknown adaptation from before the start raises the bound.
    if (!solved) bound_n += 2 * std::sqrt(replay_.silent(index, until).variance_n2);
    bound_n = std::clamp(bound_n, 0.0, largest_n_);
    const bool fired = train.last > until - history_;
    const double least_n = threshold_n + drive.least_excess_mv() * n_per_mv;
    if (bound_n < least_n) return {0, std::max(threshold_n, 0.0) / 2, false, false};
    if (!solved) {
        const double likely_n = std::min(force_n, bound_n);
        return {likely_n, std::max(likely_n, bound_n - likely_n) / 2, false, true};
    }
    const double full_scale_n = full_scale_n_[index];
    if (fired && saturated && bound_n >= (1 - most_slack) * full_scale_fraction_ * full_scale_n)
        return {full_scale_n, change_n, true, false};
    if (force_n <= bound_n) return {force_n, fired ? change_n : bound_n / 2, false, false};
    const double falling_n = bound_n * (bound_n / force_n);
    return {falling_n, std::max(change_n, bound_n - falling_n), false, false};
}

namespace {

struct Mean {
    double weights = 0;
    double force_n = 0;
    double sigma_n = 0;  // the sum of weighted ones
    double squares = 0;  // of differences from the mean
    void add(double each_n, double each_sigma_n, double weight) noexcept {
        const double difference_n = each_n - force_n;
        weights += weight;
        force_n += weight / weights * difference_n;
        squares += weight * difference_n * (each_n - force_n);
        sigma_n += weight * each_sigma_n;
    }
};

}  // namespace

template <class F>
void Inversion::for_each_reading(TimePoint until, F&& f) const noexcept {
    for (std::uint32_t i = 0; i < replay_.afferents(); ++i) {
        if (replay_.group_of(i).transient) continue;
        const Duration age = std::clamp(until - replay_.train(i).last, Duration(0), history_);
        f(reading_of(i, until), 1 / std::pow(replay_.group_of(i).drive.tau_m_s() + seconds(age), 2));
    }
}

Estimate Inversion::estimate(TimePoint now) noexcept {
    const ExponentialRate::At at = rate_.at(now);
    if (!(at.window_s() > 0)) {
        last_.sigma_n = largest_n_;
        last_.doubt = std::max(last_.doubt, Doubt::unknown);
        return last_;
    }
    const ExponentialRate::Snapshot& known = rate_.snapshot();
    const TimePoint until = std::min(now, std::max(known.heard_until, known.presumed_until));
    Mean all, firing, saturated;
    double largest_full_scale_n = 0;
    bool open = false;
    for_each_reading(until, [&](const Reading& reading, double weight) {
        all.add(reading.force_n, reading.sigma_n, weight);
        open = open || reading.open;
        if (reading.force_n > 0) firing.add(reading.force_n, reading.sigma_n, weight);
        if (!reading.saturated) return;
        saturated.add(reading.force_n, reading.sigma_n, weight);
        largest_full_scale_n = std::max(largest_full_scale_n, reading.force_n);
    });
    if (saturated.weights > 0) {
        const double others_n = all.weights > saturated.weights
                                    ? (all.weights * all.force_n - saturated.weights * saturated.force_n) /
                                          (all.weights - saturated.weights)
                                    : 0;
        all = {};
        for_each_reading(until, [&](const Reading& reading, double weight) {
            all.add(reading.saturated ? std::max(reading.force_n, others_n) : reading.force_n,
                    reading.sigma_n, weight);
        });
    }
    const double sigma_n = std::sqrt(all.squares / all.weights) + all.sigma_n / all.weights;
    const double known_part = at.known_s() / seconds(rate_time);
    last_ = {all.force_n, std::min(sigma_n / known_part, largest_n_),
             at.events() / at.known_s() / replay_.afferents()};
    if (open) last_.doubt = Doubt::slow;
    if (saturated.weights > 0 && saturated.weights >= enough_saturated * firing.weights) {
        last_.doubt = Doubt::saturated;
        last_.sigma_n = std::max(last_.sigma_n, (largest_full_scale_n - last_.force_n) / 2);
    }
    return last_;
}

void Inversion::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    rate_.resume(start, heard_until);
    replay_.restart(std::max(start, heard_until));
    std::fill(forces_.begin(), forces_.end(), Force{.force_n = last.force_n});
    last_ = last;
}

void Inversion::resume(const Snapshot& snapshot) {
    require(snapshot.forces.size() == forces_.size(), "snapshot.forces", "one for each afferent",
            static_cast<double>(snapshot.forces.size()));
    replay_.resume(snapshot.replay);
    rate_.resume(snapshot.rate);
    forces_ = snapshot.forces;
    last_ = snapshot.last;
}

std::size_t Inversion::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + replay_.heap_bytes() + forces_.capacity() * sizeof(Force) +
           full_scale_n_.capacity() * sizeof(double);
}

}  // namespace afferent
