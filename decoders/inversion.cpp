#include "afferent/decoders/inversion.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration rate_time = 40ms;  // time constant of the rate, and of how much is known
// By so much a force may change from one interval to the next.
constexpr double least_change_n = 0.3;
constexpr double part_of_change = 0.3;

}  // namespace

Inversion::Inversion(const Parameters&, const DecodedAfferents& afferents)
    : replay_(afferents),
      largest_n_(afferents.largest_grip_n),
      history_(std::max<Duration>(replay_.history(), 40 * rate_time)),
      rate_(afferents.read(), rate_time, false),
      forces_(replay_.afferents()) {
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
        const double changes_n = least_change_n + part_of_change * force.force_n;
        const SpikeReplay::Spike spike = replay_.hear(index, time, {force.force_n, changes_n * changes_n});
        if (!spike.known) continue;
        const double force_n = std::clamp(spike.told.force_n, 0.0, largest_n_);
        force = {force_n, std::abs(force_n - force.force_n)};
    }
}

void Inversion::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    rate_.lose(begin, end);
    replay_.lose(begin, end);
}

Inversion::Told Inversion::told_by(std::uint32_t index, TimePoint until) const noexcept {
    const SpikeReplay::Train& train = replay_.train(index);
    const auto& [drive, threshold_n, n_per_mv, transient] = replay_.group_of(index);
    const auto& [force_n, change_n] = forces_[index];
    const double bound_n = std::clamp(replay_.silent(index, until).force_n, 0.0, largest_n_);
    const bool fired = train.last > until - history_;
    const double least_n = threshold_n + drive.least_excess_mv() * n_per_mv;
    if (bound_n < least_n) return {0, std::max(threshold_n, 0.0) / 2};
    if (force_n <= bound_n) return {force_n, fired ? change_n : bound_n / 2};
    const double falling_n = bound_n * (bound_n / force_n);
    return {falling_n, std::max(change_n, bound_n - falling_n)};
}

Estimate Inversion::estimate(TimePoint now) noexcept {
    const ExponentialRate::At at = rate_.at(now);
    if (!(at.window_s() > 0)) {
        last_.sigma_n = largest_n_;
        return last_;
    }
    const ExponentialRate::Snapshot& known = rate_.snapshot();
    const TimePoint until = std::min(now, std::max(known.heard_until, known.presumed_until));
    double weights = 0;
    double force_n = 0;
    double sigma_n = 0;
    double squares = 0;
    for (std::uint32_t i = 0; i < replay_.afferents(); ++i) {
        if (replay_.group_of(i).transient) continue;
        const Duration age = std::clamp(until - replay_.train(i).last, Duration(0), history_);
        const double weight = 1 / std::pow(replay_.group_of(i).drive.tau_m_s() + seconds(age), 2);
        const Told told = told_by(i, until);
        const double difference_n = told.force_n - force_n;
        weights += weight;
        force_n += weight / weights * difference_n;
        squares += weight * difference_n * (told.force_n - force_n);
        sigma_n += weight * told.sigma_n;
    }
    sigma_n = std::sqrt(squares / weights) + sigma_n / weights;
    const double known_part = at.known_s() / seconds(rate_time);
    last_ = {force_n, std::min(sigma_n / known_part, largest_n_),
             at.events() / at.known_s() / replay_.afferents()};
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
    return sizeof(*this) + rate_.heap_bytes() + replay_.heap_bytes() + forces_.capacity() * sizeof(Force);
}

}  // namespace afferent
