#include "afferent/decoders/filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration known_for = 40ms;  // time constant of what is known, and of the rate
constexpr Duration batch_length = 3ms;
// Silence is taken in this often. More often, and moment matching shrinks the belief by its own error.
constexpr Duration silence_step = 10ms;
// So many of those that have been silent for longest may have the lowest bound.
constexpr int silent_ones = 8;
// Beyond this many standard deviations a bound contradicts what is believed.
constexpr double contradiction = 4;
constexpr std::uint16_t dead_after = 10;
// A spike is odd beyond so many standard deviations (squared), and counts against its afferent three times as
// much as another speaks for it. What is yet further off is not taken for a measurement if others have just
// told the force. Where so many are odd it is the belief that is wrong.
constexpr double odd_misfit = 9;
constexpr double absurd_misfit = 25;
constexpr std::uint16_t odd_step = 3;
constexpr std::uint16_t odd_after = 18;
constexpr std::uint16_t most_oddities = 30;
constexpr std::uint16_t trusted_below = 6;
constexpr std::uint16_t on_probation = 12;
constexpr Duration forgiven_after = 10s;
constexpr double common_surprise = 0.4;
constexpr double surprise_memory = 1.0 / 16;
// The force has turned where it is surely, by so many standard deviations, on this side of where it surely
// was, and by so much of the hysteresis.
constexpr double sure = 2;
constexpr double turn = 0.5;
constexpr int turned_after = 5;  // measurements
// Beside their noise, two sensors differ by this, and by this part of the force.
constexpr double differ_n = 0.005;
constexpr double differ_part = 0.002;
// A rate of change is off by this part of it.
constexpr double speed_noise_part = 0.05;
// About how long ago the force was that a spike tells of.
constexpr double usual_lag_s = 0.006;
constexpr std::uint32_t not_linked = std::numeric_limits<std::uint32_t>::max();
// At its full scale an element tells the least of what the force may be.
constexpr double saturated = 0.98;
// A bound of the rate of change beyond this is none.
constexpr double fastest_bound_n_per_s = 200;

constexpr TimePoint start_of(TimePoint time, Duration step) { return time - (time - scene_start) % step; }

}  // namespace

Filter::Filter(const Parameters& parameters, const DecodedAfferents& afferents)
    : replay_(afferents),
      force_(parameters.force),
      rate_(afferents.read(), known_for, false),
      largest_n_(afferents.largest_grip_n),
      threshold_n_(afferents.largest_grip_n),
      hysteresis_(afferents.hysteresis),
      scan_s_(seconds(afferents.scan)),
      history_(std::max<Duration>(replay_.history(), 30s)),
      places_(replay_.afferents() + 1),
      heard_(afferents.groups.size()),
      progress_{ForceBelief(parameters.force, largest_n_), scene_start} {
    for (std::uint32_t i = 0; i < replay_.afferents(); ++i)
        if (const auto& group = replay_.group_of(i); !group.transient) {
            threshold_n_ = std::min(threshold_n_, group.threshold_n);
            ++sustained_;
        }
    for (const DecodedAfferents::Group& group : afferents.groups)
        sensing_.push_back({std::min(largest_n_, saturated * group.full_scale_n), group.noise_n + differ_n,
                            group.noise_part + differ_part});
    restart(scene_start);
}

// A sample is held, and is half of that time old in the mean; a slope is that of the time before it as well.
SpikeReplay::Told Filter::sensed_speed(std::uint32_t index, SpikeReplay::Told told) const noexcept {
    const double of_two_samples_n = std::numbers::sqrt2 * sensing_[replay_.group(index)].noise_n;
    const double sensor_n_per_s =
        of_two_samples_n / std::max(scan_s_, 1e-3) + speed_noise_part * std::abs(told.force_n);
    told.lag_s += scan_s_;
    told.variance_n2 += sensor_n_per_s * sensor_n_per_s;
    return told;
}

SpikeReplay::Told Filter::sensed(std::uint32_t index, SpikeReplay::Told told) const noexcept {
    const Sensing& sensing = sensing_[replay_.group(index)];
    const double sensor_n = sensing.noise_n + sensing.noise_part * std::abs(told.force_n);
    told.lag_s += scan_s_ / 2;
    told.variance_n2 += sensor_n * sensor_n;
    return told;
}

bool Filter::left_out(Address address) const noexcept {
    const std::uint32_t index = replay_.index_of(address);
    return index != SpikeReplay::not_read && !replay_.group_of(index).transient &&
           places_[index].after == not_linked;
}

void Filter::unlink(std::uint32_t index) noexcept {
    Place& place = places_[index];
    if (place.after == not_linked) return;
    places_[place.before].after = place.after;
    places_[place.after].before = place.before;
    place.before = place.after = not_linked;
    --listed_;
}

void Filter::link(std::uint32_t index, std::uint32_t before, std::uint32_t after) noexcept {
    places_[index].before = before;
    places_[index].after = after;
    places_[before].after = index;
    places_[after].before = index;
    ++listed_;
}

void Filter::append(std::uint32_t index) noexcept {
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    link(index, places_[head].before, head);
    places_[index].silences = 0;
}

Filter::Bound Filter::bound(TimePoint until, const ForceBelief& belief) const noexcept {
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    const bool measuring = until - measured_ < silence_step;
    const double least_n =
        measuring ? belief.mean_n() - contradiction * std::sqrt(belief.variance_n2()) : -largest_n_;
    Bound lowest{largest_n_, 0};
    std::uint32_t index = places_[head].after;
    for (int i = 0; i < silent_ones && index != head; ++i, index = places_[index].after) {
        if (until <= replay_.train(index).since) continue;
        const SpikeReplay::Told silent = sensed(index, replay_.silent(index, until));
        const double force_n = silent.force_n + 3 * std::sqrt(silent.variance_n2);
        if (force_n < lowest.force_n && force_n >= least_n) lowest = {force_n, silent.lag_s};
    }
    return lowest;
}

// Whether most of those that have been silent for longest would have fired at that force.
bool Filter::outvoted(double force_n, TimePoint time) const noexcept {
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    int votes = 0;
    int against = 0;
    std::uint32_t index = places_[head].after;
    for (int i = 0; i < silent_ones && index != head; ++i, index = places_[index].after) {
        if (time <= replay_.train(index).since) continue;
        const SpikeReplay::Told silent = sensed(index, replay_.silent(index, time));
        ++votes;
        against += silent.force_n + 3 * std::sqrt(silent.variance_n2) < force_n;
    }
    return votes > 1 && 2 * against > votes;
}

void Filter::settle(Progress& progress, TimePoint until) const noexcept {
    if (batch_.weight > 0) {
        progress.belief.measure(batch_.force / batch_.weight, batch_.lag / batch_.weight, 1 / batch_.weight);
        follow_hysteresis(progress);
    }
    const auto pass = [&](TimePoint to) {
        progress.belief.predict(seconds(to - progress.time));
        progress.time = std::max(progress.time, to);
    };
    for (TimePoint step = start_of(progress.time, silence_step) + silence_step; step <= until;
         step += silence_step) {
        pass(step);
        const Bound silent = bound(step, progress.belief);
        progress.belief.bound(silent.force_n, silent.lag_s);
        if (transient_ != SpikeReplay::not_read) {
            const SpikeReplay::Told still = sensed_speed(transient_, replay_.silent(transient_, step));
            const double bound = still.force_n + 2 * std::sqrt(still.variance_n2);
            if (bound < fastest_bound_n_per_s) progress.belief.bound_speed(bound, still.lag_s);
        }
    }
    pass(until);
}

double Filter::beyond_turn_n(const Progress& progress) const noexcept {
    const double back_n = progress.side * (progress.extreme_n - progress.belief.mean_n());
    return back_n - sure * std::sqrt(progress.belief.variance_n2()) -
           turn * hysteresis_ * std::abs(progress.extreme_n);
}

void Filter::follow_hysteresis(Progress& progress) const noexcept {
    const double mean_n = progress.belief.mean_n();
    if (beyond_turn_n(progress) <= 0) {
        progress.turning = 0;
        const double surely_n = mean_n - progress.side * sure * std::sqrt(progress.belief.variance_n2());
        if (progress.side * (surely_n - progress.extreme_n) >= 0) progress.extreme_n = surely_n;
        return;
    }
    if (progress.turning == 0 || progress.side * (mean_n - progress.turned_n) < 0) progress.turned_n = mean_n;
    if (++progress.turning < turned_after) return;
    progress.side = -progress.side;
    progress.extreme_n = progress.turned_n;
    progress.turning = 0;
}

void Filter::commit(TimePoint until) noexcept {
    const TimePoint before = progress_.time;
    settle(progress_, until);
    batch_ = {progress_.time};
    if (start_of(before, silence_step) != start_of(progress_.time, silence_step)) find_dead();
    if (start_of(before, forgiven_after) != start_of(progress_.time, forgiven_after)) forgive();
}

// Everybody on probation: what an afferent did long ago does not count, and who is still bad is found at
// once.
void Filter::forgive() noexcept {
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    for (std::uint32_t index = 0; index < head; ++index) {
        Place& place = places_[index];
        place.odd = false;
        place.oddities = on_probation;
        place.silences = 0;
        if (place.after != not_linked || replay_.group_of(index).transient) continue;
        link(index, head, places_[head].after);
    }
}

void Filter::find_dead() noexcept {
    if (progress_.time - measured_ >= silence_step) return;
    const double least_n =
        progress_.belief.mean_n() - contradiction * std::sqrt(progress_.belief.variance_n2());
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    std::uint32_t index = places_[head].after;
    for (int i = 0; i < silent_ones && index != head; ++i) {
        const std::uint32_t after = places_[index].after;
        if (progress_.time > replay_.train(index).since) {
            const SpikeReplay::Told silent = sensed(index, replay_.silent(index, progress_.time));
            const bool contradicts = silent.force_n + 3 * std::sqrt(silent.variance_n2) < least_n;
            std::uint16_t& silences = places_[index].silences;
            silences = contradicts ? static_cast<std::uint16_t>(silences + 1) : std::uint16_t{0};
            if (silences >= dead_after) unlink(index);
        }
        index = after;
    }
}

void Filter::take(const Event& event) noexcept {
    const std::uint32_t index = replay_.index_of(event.address);
    if (replay_.group_of(index).transient) return take_transient(index, event.time);
    if (event.time >= batch_.begin + batch_length || batch_.weight == 0) commit(event.time);
    const double since_begin_s = seconds(event.time - batch_.begin);
    const auto expected = [&](double lag_s) {
        const ForceBelief::Moments past = progress_.belief.of_past(lag_s - since_begin_s);
        return SpikeReplay::Expected{past.mean_n, past.variance_n2};
    };
    const SpikeReplay::Spike spike = replay_.lost_since(index)
                                         ? replay_.hear(index, event.time, expected(usual_lag_s))
                                         : replay_.hear(index, event.time);
    if (spike.known) {
        measure(spike, index, event.time);
        if (replay_.train(index).doubt_g > 0 && replay_.afferents() > 1)
            replay_.correct(index, sensed(index, spike.told), expected(spike.told.lag_s));
    }
    unlink(index);
    if (!places_[index].odd) append(index);
}

void Filter::take_transient(std::uint32_t index, TimePoint time) noexcept {
    commit(time);
    const ForceBelief::Moments expected = progress_.belief.of_speed();
    const SpikeReplay::Spike spike = replay_.lost_since(index)
                                         ? replay_.hear(index, time, {expected.mean_n, expected.variance_n2})
                                         : replay_.hear(index, time);
    transient_ = index;
    Heard& heard = heard_[replay_.group(index)];
    if (!spike.known || heard == Heard{spike.begin, time}) return;
    heard = {spike.begin, time};
    const auto [speed_n_per_s, lag_s, variance] = sensed_speed(index, spike.told);
    progress_.belief.measure_speed(speed_n_per_s, lag_s, variance);
}

void Filter::measure(const SpikeReplay::Spike& spike, std::uint32_t index, TimePoint time) noexcept {
    const auto [force_n, lag_s, variance_n2] = sensed(index, spike.told);
    // At full scale or beyond it is no force.
    if (!(force_n <= sensing_[replay_.group(index)].largest_n)) return;
    Heard& heard = heard_[replay_.group(index)];
    if (heard == Heard{spike.begin, time}) return;
    heard = {spike.begin, time};
    const double since_begin_s = seconds(time - batch_.begin);
    const double misfit = progress_.belief.misfit(force_n, lag_s - since_begin_s, variance_n2);
    Place& place = places_[index];
    if (replay_.afferents() > 1) {
        const bool odd = misfit > odd_misfit;
        const bool others_told = time - measured_ < 2 * silence_step && surprise_ < common_surprise;
        // Who speaks alone is held against the silence of the others.
        const bool alone = (odd || index == speaker_) && outvoted(force_n, time);
        const bool contradicted = alone || (odd && others_told);
        if (contradicted)
            place.oddities = std::min<std::uint16_t>(place.oddities + odd_step, most_oddities);
        else if (!odd)
            place.oddities = static_cast<std::uint16_t>(std::max(place.oddities - 1, 0));
        place.odd = place.oddities >= (place.odd ? trusted_below : odd_after);
        if (place.odd) return;
        surprise_ += ((odd ? 1 : 0) - surprise_) * surprise_memory;
        if (alone || (contradicted && misfit > absurd_misfit)) return;
    }
    const double weight = 1 / variance_n2;
    batch_.weight += weight;
    batch_.force += weight * force_n;
    batch_.lag += weight * (lag_s - since_begin_s);
    measured_ = time;
    speaker_ = index;
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
    const Bound silent = bound(known_until, progress_.belief);
    progress_.belief.bound(silent.force_n, silent.lag_s);
    rate_.lose(begin, end);
    replay_.lose(begin, end);
    // In one step, however long it is.
    progress_.belief.predict(seconds(end - progress_.time));
    progress_.time = std::max(progress_.time, end);
    batch_ = {progress_.time};
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
    // Silence says no more than that the force is below the threshold, and less while an adaptation lasts.
    if (force_n < threshold_n_) {
        const double silent_n = std::min(silent.force_n, 2 * threshold_n_);
        variance_n2 += force_n * force_n + silent_n * silent_n / 4;
        force_n = 0;
    }
    // Silence alone may say that the force falls.
    const double side = progress.side > 0 && beyond_turn_n(progress) > 0 ? -1 : progress.side;
    // Within the play the sensors tell nothing.
    variance_n2 += std::pow(hysteresis_ * force_n / 2, 2);
    force_n = std::min(force_n / (1 - hysteresis_ * side), largest_n_);
    last_ = {force_n, std::min(std::sqrt(variance_n2), largest_n_),
             at.events() / at.known_s() / replay_.afferents(), sustained_ - listed_};
    return last_;
}

void Filter::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    const TimePoint begin = std::max(start, heard_until);
    rate_.resume(start, heard_until);
    replay_.restart(begin);
    const auto head = static_cast<std::uint32_t>(places_.size() - 1);
    std::fill(places_.begin(), places_.end(), Place{head, head, 0, 0, false});
    listed_ = 0;
    for (std::uint32_t i = 0; i < head; ++i)
        if (!replay_.group_of(i).transient) append(i);
    std::fill(heard_.begin(), heard_.end(), Heard{begin, begin});
    progress_ = {ForceBelief(force_, largest_n_), begin};
    batch_ = {begin};
    measured_ = span_begin_ = begin;
    transient_ = speaker_ = SpikeReplay::not_read;
    surprise_ = 0;
    last_ = last;
}

Filter::Snapshot Filter::snapshot() const {
    return {rate_.snapshot(), replay_.snapshot(), places_,    listed_,   heard_,      progress_, batch_,
            measured_,        speaker_,           transient_, surprise_, span_begin_, last_};
}

void Filter::resume(const Snapshot& snapshot) {
    require(snapshot.places.size() == places_.size() && snapshot.heard.size() == heard_.size(),
            "snapshot.places", "one for each afferent and one more",
            static_cast<double>(snapshot.places.size()));
    replay_.resume(snapshot.replay);
    rate_.resume(snapshot.rate);
    places_ = snapshot.places;
    listed_ = snapshot.listed;
    heard_ = snapshot.heard;
    progress_ = snapshot.progress;
    batch_ = snapshot.batch;
    measured_ = snapshot.measured;
    transient_ = snapshot.transient;
    speaker_ = snapshot.speaker;
    span_begin_ = snapshot.span_begin;
    surprise_ = snapshot.surprise;
    last_ = snapshot.last;
}

std::size_t Filter::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + replay_.heap_bytes() + places_.capacity() * sizeof(Place) +
           heard_.capacity() * sizeof(Heard) + sensing_.capacity() * sizeof(Sensing);
}

}  // namespace afferent
