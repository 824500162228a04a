#include "afferent/decoders/filter.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration known_for = 40ms;  // time constant of what is known, and of the rate
constexpr Duration batch_length = 1ms;
// Silence is taken in this often. More often, and moment matching shrinks the belief by its own error.
constexpr Duration silence_step = 10ms;
// So many of those that have been silent for longest may have the lowest bound.
constexpr int silent_ones = 8;
// Beyond this many standard deviations a bound contradicts what is believed.
constexpr double contradiction = 4;
constexpr std::uint32_t dead_after = 10;
// So many standard deviations from its extreme, and half of the hysteresis, the force has turned.
constexpr double turned = 3;
// What a sensor adds to each measurement: half a count or so, and how far two sensors differ.
constexpr double noise_n = 0.01;
constexpr double noise_part = 0.003;
// Samples are held, for 5 ms at the usual 200 Hz, and are half as old as that in the mean.
constexpr double held_s = 0.0025;
constexpr std::uint32_t left_out = std::numeric_limits<std::uint32_t>::max();

constexpr TimePoint start_of(TimePoint time, Duration step) { return time - (time - scene_start) % step; }

}  // namespace

Filter::Filter(const Parameters& parameters, const DecodedAfferents& afferents)
    : replay_(afferents),
      force_(parameters.force),
      rate_(afferents.read(), known_for, false),
      largest_n_(afferents.largest_grip_n),
      threshold_n_(afferents.largest_grip_n),
      tick_s_(seconds(afferents.tick)),
      hysteresis_(afferents.hysteresis),
      history_(std::max<Duration>(replay_.history(), 20s)),
      places_(replay_.afferents() + 1),
      heard_(afferents.groups.size()),
      progress_{ForceBelief(parameters.force, largest_n_), scene_start} {
    for (const auto& [address, group, share] : afferents.afferents)
        if (replay_.index_of(address) != SpikeReplay::not_read) group_of_.push_back(group);
    for (std::uint32_t i = 0; i < replay_.afferents(); ++i)
        threshold_n_ = std::min(threshold_n_, replay_.group_of(i).threshold_n);
    restart(scene_start);
}

// An error of the stamps, of uniform ticks at both ends, is one of the interval T:  dc/dT = −(c − g W)/(Ψ
// tau_m).
Filter::Told Filter::told(std::uint32_t index, TimePoint until) const noexcept {
    const SpikeReplay::Train& train = replay_.train(index);
    const auto& [drive, threshold_n, n_per_mv] = replay_.group_of(index);
    const Duration interval = until - train.replayed;
    const double excess_mv = drive.excess_mv(train.g, interval);
    const double force_n = threshold_n + excess_mv * n_per_mv;
    const double tick_n = drive.excess_per_s_mv(excess_mv, train.g, interval) * n_per_mv * tick_s_;
    const double doubt_n = drive.excess_per_g_mv() * drive.decayed(train.doubt_g, interval) * n_per_mv;
    const double sensor_n = noise_n + noise_part * std::abs(force_n);
    return {force_n, drive.delay_s(train.g, interval) + held_s,
            tick_n * tick_n / 6 + doubt_n * doubt_n + sensor_n * sensor_n};
}

void Filter::unlink(std::uint32_t index) noexcept {
    Place& place = places_[index];
    if (place.after == left_out) return;
    places_[place.before].after = place.after;
    places_[place.after].before = place.before;
    place.before = place.after = left_out;
}

void Filter::append(std::uint32_t index) noexcept {
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    places_[index] = {.before = places_[head].before, .after = head, .doubts = 0};
    places_[places_[head].before].after = index;
    places_[head].before = index;
}

Filter::Bound Filter::bound(TimePoint until, const ForceBelief& belief) const noexcept {
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    const bool measuring = until - measured_ < silence_step;
    const double least_n =
        measuring ? belief.mean_n() - contradiction * std::sqrt(belief.variance_n2()) : -largest_n_;
    Bound lowest{largest_n_, 0};
    std::uint32_t index = places_[head].after;
    for (int i = 0; i < silent_ones && index != head; ++i, index = places_[index].after) {
        if (until <= replay_.train(index).replayed) continue;
        const Told silent = told(index, until);
        const double force_n = silent.force_n + 2 * std::sqrt(silent.variance_n2);
        if (force_n < lowest.force_n && force_n >= least_n) lowest = {force_n, silent.lag_s};
    }
    return lowest;
}

void Filter::settle(Progress& progress, TimePoint until) const noexcept {
    const auto pass = [&](TimePoint to) {
        progress.belief.predict(seconds(to - progress.time));
        progress.time = std::max(progress.time, to);
    };
    if (batch_.weight > 0) {
        pass(batch_.end);
        progress.belief.measure(batch_.force / batch_.weight, batch_.lag / batch_.weight, 1 / batch_.weight);
    }
    for (TimePoint step = start_of(progress.time, silence_step) + silence_step; step <= until;
         step += silence_step) {
        pass(step);
        const Bound silent = bound(step, progress.belief);
        progress.belief.bound(silent.force_n, silent.lag_s);
        follow_hysteresis(progress);
    }
}

void Filter::follow_hysteresis(Progress& progress) const noexcept {
    const double mean_n = progress.belief.mean_n();
    const double beyond_n = progress.side * (mean_n - progress.extreme_n);
    const double turned_n = std::max(turned * std::sqrt(progress.belief.variance_n2()),
                                     hysteresis_ / 2 * std::abs(progress.extreme_n));
    if (beyond_n < -turned_n) progress.side = -progress.side;
    if (beyond_n >= 0 || beyond_n < -turned_n) progress.extreme_n = mean_n;
}

void Filter::commit(TimePoint until) noexcept {
    const TimePoint before = progress_.time;
    settle(progress_, until);
    batch_ = {};
    if (start_of(before, silence_step) != start_of(progress_.time, silence_step)) find_dead();
}

void Filter::find_dead() noexcept {
    if (progress_.time - measured_ >= silence_step) return;
    const double least_n =
        progress_.belief.mean_n() - contradiction * std::sqrt(progress_.belief.variance_n2());
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    std::uint32_t index = places_[head].after;
    for (int i = 0; i < silent_ones && index != head; ++i) {
        const std::uint32_t after = places_[index].after;
        if (progress_.time > replay_.train(index).replayed) {
            const Told silent = told(index, progress_.time);
            const bool contradicts = silent.force_n + 2 * std::sqrt(silent.variance_n2) < least_n;
            places_[index].doubts = contradicts ? places_[index].doubts + 1 : 0;
            if (places_[index].doubts >= dead_after) unlink(index);
        }
        index = after;
    }
}

void Filter::take(const Event& event) noexcept {
    const std::uint32_t index = replay_.index_of(event.address);
    const TimePoint batch_end = start_of(event.time, batch_length) + batch_length;
    if (batch_end != batch_.end) {
        commit(batch_end - batch_length);
        batch_.end = batch_end;
    }
    if (replay_.solvable(index, event.time)) {
        const Told spike = told(index, event.time);
        const Heard interval{replay_.train(index).replayed, event.time};
        // Beyond the range of the sensors it is no force.
        if (spike.force_n <= largest_n_ && heard_[group_of_[index]] != interval) {
            const double weight = 1 / spike.variance_n2;
            batch_.weight += weight;
            batch_.force += weight * spike.force_n;
            batch_.lag += weight * (spike.lag_s + seconds(batch_end - event.time));
            measured_ = event.time;
            heard_[group_of_[index]] = interval;
        }
    }
    replay_.fire(index, event.time);
    unlink(index);
    append(index);
}

void Filter::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > heard_until()) lose(heard_until(), begin);
    // No part of an earlier span comes any more.
    if (begin != span_begin_ && begin >= heard_until()) commit(begin);
    span_begin_ = begin;
    const TimePoint counted_from = rate_.snapshot().counted_from;
    rate_.observe(begin, end, events);
    for (const Event& event : events)
        if (replay_.index_of(event.address) != SpikeReplay::not_read && event.time >= counted_from)
            take(event);
}

void Filter::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    const TimePoint known_until = std::min(begin, heard_until());
    commit(known_until);
    if (known_until > progress_.time) {
        progress_.belief.predict(seconds(known_until - progress_.time));
        progress_.time = known_until;
        const Bound silent = bound(known_until, progress_.belief);
        progress_.belief.bound(silent.force_n, silent.lag_s);
    }
    rate_.lose(begin, end);
    replay_.lose(begin, end);
    // In one step, however long it is.
    progress_.belief.predict(seconds(end - progress_.time));
    progress_.time = std::max(progress_.time, end);
}

Estimate Filter::estimate(TimePoint now) noexcept {
    const ExponentialRate::At at = rate_.at(now);
    if (!(at.window_s() > 0)) {
        last_.sigma_n = largest_n_;
        return last_;
    }
    const ExponentialRate::Snapshot& known = rate_.snapshot();
    const TimePoint until = std::min(now, std::max(known.heard_until, known.presumed_until));
    Progress progress = progress_;
    settle(progress, until);
    const Bound silent = bound(until, progress.belief);
    progress.belief.predict(seconds(now - progress.time));
    progress.belief.bound(silent.force_n, silent.lag_s + seconds(now - until));
    double force_n = progress.belief.mean_n();
    double variance_n2 = progress.belief.variance_n2();
    if (force_n < threshold_n_) {
        variance_n2 += force_n * force_n + threshold_n_ * threshold_n_ / 4;
        force_n = 0;
    }
    // Within the play the sensors tell nothing.
    variance_n2 += std::pow(hysteresis_ * force_n / 2, 2);
    force_n = std::min(force_n / (1 - hysteresis_ * progress.side), largest_n_);
    last_ = {force_n, std::min(std::sqrt(variance_n2), largest_n_),
             at.events() / at.known_s() / replay_.afferents()};
    return last_;
}

void Filter::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    const TimePoint begin = std::max(start, heard_until);
    rate_.resume(start, heard_until);
    replay_.restart(begin);
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    places_[head] = {head, head, 0};
    for (std::uint32_t i = 0; i < head; ++i) append(i);
    std::fill(heard_.begin(), heard_.end(), Heard{begin, begin});
    progress_ = {ForceBelief(force_, largest_n_), begin};
    batch_ = {.end = begin};
    measured_ = span_begin_ = begin;
    last_ = last;
}

Filter::Snapshot Filter::snapshot() const {
    return {rate_.snapshot(), replay_.trains(), places_,     heard_, progress_,
            batch_,           measured_,        span_begin_, last_};
}

void Filter::resume(const Snapshot& snapshot) {
    require(snapshot.places.size() == places_.size() && snapshot.heard.size() == heard_.size(),
            "snapshot.places", "one for each afferent and one more",
            static_cast<double>(snapshot.places.size()));
    replay_.resume(snapshot.trains);
    rate_.resume(snapshot.rate);
    places_ = snapshot.places;
    heard_ = snapshot.heard;
    progress_ = snapshot.progress;
    batch_ = snapshot.batch;
    measured_ = snapshot.measured;
    span_begin_ = snapshot.span_begin;
    last_ = snapshot.last;
}

std::size_t Filter::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + replay_.heap_bytes() + places_.capacity() * sizeof(Place) +
           heard_.capacity() * sizeof(Heard) + group_of_.capacity() * sizeof(std::uint32_t);
}

}  // namespace afferent
