#include "afferent/decoders/inversion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration time_constant = 40ms;  // of the rate, and of how much is known
constexpr std::uint32_t not_read = std::numeric_limits<std::uint32_t>::max();
// No spike; far from overflow.
constexpr TimePoint never_fired = scene_start - std::chrono::hours(24 * 365 * 100);

}  // namespace

Inversion::Inversion(const Parameters&, const DecodedAfferents& afferents)
    : index_of_(afferents.addresses, not_read),
      largest_n_(afferents.largest_grip_n),
      history_(40 * time_constant),
      rate_(afferents.read(), time_constant, false) {
    afferents.check();
    for (const DecodedAfferents::Group& group : afferents.groups) {
        const IntervalDrive drive(group.neuron);
        const double longest_s = 40 * std::max(drive.tau_g_s(), drive.tau_m_s());
        groups_.push_back(
            {drive, group.drive_mv_per_n > 0 ? group.threshold_n() : 0, 1 / group.drive_mv_per_n});
        history_ = std::max(history_, rounded(Seconds(longest_s)));
    }
    for (const auto& [address, group, share] : afferents.afferents) {
        if (!(share > 0 && afferents.groups[group].drive_mv_per_n > 0)) continue;
        if (!(groups_[group].threshold_n < largest_n_))
            throw ParameterError("patch", "patches that fire within the range of their sensors",
                                 "silent up to " + std::to_string(largest_n_) + " N of grip force");
        index_of_[address] = static_cast<std::uint32_t>(group_of_.size());
        group_of_.push_back(group);
    }
    require(!group_of_.empty(), "patch", "at least one patch whose elements have a share", 0);
    trains_.resize(group_of_.size());
    restart(scene_start);
}

// The force of an interval that ends at `until`, or the bound that this time without a spike sets.
double Inversion::solved_n(const Group& group, const Train& train, TimePoint until) const noexcept {
    const double excess_mv = group.drive.excess_mv(train.g, until - train.replayed);
    const double force_n = group.threshold_n + excess_mv * group.n_per_mv;
    return std::clamp(force_n, 0.0, largest_n_);
}

void Inversion::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > heard_until()) lose(heard_until(), begin);
    const TimePoint counted_from = rate_.snapshot().counted_from;
    rate_.observe(begin, end, events);
    for (const auto& [time, address] : events) {
        if (index_of_[address] == not_read || time < counted_from) continue;
        Train& train = trains_[index_of_[address]];
        const Group& group = groups_[group_of_[index_of_[address]]];
        const Duration interval = std::max(time - train.replayed, 0ns);
        const bool whole = train.last >= counted_from;
        if (interval > 0ns && (whole || seconds(interval) > 5 * group.drive.tau_m_s())) {
            const double force_n = solved_n(group, train, time);
            train.change_n = std::abs(force_n - train.force_n);
            train.force_n = force_n;
        }
        if (whole && interval > 0ns) train.rate_hz = 1 / seconds(interval);
        train.g = group.drive.after_spike(group.drive.decayed(train.g, interval));
        train.last = train.replayed = time;
    }
}

void Inversion::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    rate_.lose(begin, end);
    for (std::size_t i = 0; i < trains_.size(); ++i) {
        Train& train = trains_[i];
        const IntervalDrive& drive = groups_[group_of_[i]].drive;
        if (end <= train.replayed) continue;
        const TimePoint known_until = std::max(train.replayed, begin);
        const Duration waiting = known_until - std::max(train.last, train.replayed);
        const double rate_hz = waiting > 0ns ? std::min(train.rate_hz, 1 / seconds(waiting)) : train.rate_hz;
        train.g = drive.driven(drive.decayed(train.g, known_until - train.replayed), end - known_until,
                               train.last < end - history_ ? 0 : rate_hz);
        train.replayed = end;
    }
}

Inversion::Told Inversion::told_by(const Group& group, const Train& train, TimePoint until) const noexcept {
    const double bound_n = until > train.replayed ? solved_n(group, train, until) : largest_n_;
    const bool fired = train.last > until - history_;
    const double least_n = group.threshold_n + group.drive.least_excess_mv() * group.n_per_mv;
    if (bound_n < least_n) return {0, std::max(group.threshold_n, 0.0) / 2};
    if (train.force_n <= bound_n) return {train.force_n, fired ? train.change_n : bound_n / 2};
    const double falling_n = bound_n * (bound_n / train.force_n);
    return {falling_n, std::max(train.change_n, bound_n - falling_n)};
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
    for (std::size_t i = 0; i < trains_.size(); ++i) {
        const Group& group = groups_[group_of_[i]];
        const Duration age = std::clamp(until - trains_[i].last, Duration(0), history_);
        const double weight = 1 / std::pow(group.drive.tau_m_s() + seconds(age), 2);
        const Told told = told_by(group, trains_[i], until);
        const double difference_n = told.force_n - force_n;
        weights += weight;
        force_n += weight / weights * difference_n;
        squares += weight * difference_n * (told.force_n - force_n);
        sigma_n += weight * told.sigma_n;
    }
    sigma_n = std::sqrt(squares / weights) + sigma_n / weights;
    const double known_part = at.known_s() / seconds(time_constant);
    last_ = {force_n, std::min(sigma_n / known_part, largest_n_),
             at.events() / at.known_s() / static_cast<double>(trains_.size())};
    return last_;
}

void Inversion::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    rate_.resume(start, heard_until);
    std::fill(trains_.begin(), trains_.end(),
              Train{.last = never_fired, .replayed = std::max(start, heard_until), .force_n = last.force_n});
    last_ = last;
}

void Inversion::resume(const Snapshot& snapshot) {
    require(snapshot.trains.size() == trains_.size(), "snapshot.trains", "one for each afferent",
            static_cast<double>(snapshot.trains.size()));
    rate_.resume(snapshot.rate);
    trains_ = snapshot.trains;
    last_ = snapshot.last;
}

std::size_t Inversion::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + groups_.capacity() * sizeof(Group) +
           (group_of_.capacity() + index_of_.capacity()) * sizeof(std::uint32_t) +
           trains_.capacity() * sizeof(Train);
}

}  // namespace afferent
