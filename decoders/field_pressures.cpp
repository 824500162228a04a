#include "afferent/decoders/field_pressures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Changes of the pressure that are older than this say nothing of the present.
constexpr Duration of_late = 100ms;
// An afferent that has been silent for longer begins a train of spikes. What the first of them measures may
// be the pressure on its way to a higher one, to which the afferent adapts: its bound by silence approaches
// that within `settles`.
constexpr Duration begins_train = 300ms;
constexpr double settles_s = 0.3;
// Measured a moment apart, two pressures differ by more than they have changed.
constexpr double least_interval_s = 5e-3;
// Pressures change by up to this many times the root mean square of what has been measured.
constexpr double most_change = 2;
// By these parts of a pressure it may have changed in a second that was heard, and in one that was lost.
constexpr double may_change_per_s = 1;
constexpr double changes_while_moving_per_s = 2;  // heard, of a contact that moves
constexpr double may_change_unheard_per_s = 10;
// A bound by silence holds but for so many standard deviations.
constexpr double bounds_at = 2;
// An afferent whose bound has fallen by this part below what it has measured is touched no more.
constexpr double left_below = 0.25;
// A measurement older than this is forgotten. Then silence alone bounds the pressure: an afferent that is
// touched may have adapted to it for good.
constexpr Duration forgotten_after = 500ms;
// From this part of full scale on, a spike says no more than "at least so much".
constexpr double nearly_full = 0.98;
// The pressure rises if a measurement is higher than the one before it by this part.
constexpr double least_rise = 0.03;
// After a loss a spike is held against the last pressure, within this part of it and so many units.
constexpr double expected_part = 0.5;
constexpr double expected_units = 0.3;

bool is_remembered(const FieldPressures::Last& last, TimePoint now) {
    return last.pressure > 0 && now - last.time <= forgotten_after;
}

}  // namespace

FieldPressures::FieldPressures(const DecodedAfferents& afferents, std::vector<double> unit_n_per_mm2,
                               std::span<const SkinField> fields,
                               std::vector<CommonChange::Transient> transients)
    : replay_(afferents),
      unit_n_per_mm2_(std::move(unit_n_per_mm2)),
      last_(replay_.afferents()),
      branches_(replay_.afferents(), HysteresisBranch(afferents.hysteresis)),
      untouched_(afferents.hysteresis),
      change_(afferents.addresses, fields, std::move(transients)),
      held_(change_.held().size()),
      scan_(afferents.scan) {
    require(unit_n_per_mm2_.size() == replay_.afferents(), "unit_n_per_mm2", "one for each afferent",
            static_cast<double>(unit_n_per_mm2_.size()));
    require(held_.empty() || held_.size() == replay_.afferents(), "fields", "one for each afferent",
            static_cast<double>(held_.size()));
    for (const auto& afferent : afferents.afferents) {
        const DecodedAfferents::Group& group = afferents.groups[afferent.group];
        sensing_.push_back({nearly_full * group.full_scale_n, group.noise_n, group.noise_fraction});
    }
    resume_after(scene_start, scene_start);
}

double FieldPressures::sensor_sigma(std::uint32_t index, double pressure) const noexcept {
    return sensing_[index].noise + sensing_[index].noise_fraction * pressure;
}

void FieldPressures::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > heard_until_) lose(heard_until_, begin);
    for (const Event& event : events) {
        if (event.time < counted_from_) continue;
        if (const auto index = replay_.index_of(event.address); index != SpikeReplay::not_read)
            take(index, event.time);
        else if (const auto transient = change_.index_of(event.address); transient != CommonChange::not_read)
            take_transient(transient, event.time);
    }
    heard_until_ = std::max(heard_until_, end);
}

void FieldPressures::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    replay_.lose(begin, end);
    counted_from_ = std::max(counted_from_, end);
    heard_until_ = std::max(heard_until_, end);
}

void FieldPressures::presume_silence(TimePoint until) noexcept {
    presumed_until_ = std::max(presumed_until_, until);
}

void FieldPressures::take(std::uint32_t index, TimePoint time) noexcept {
    Last& last = last_[index];
    const TimePoint fired = replay_.train(index).last;
    const double sigma = expected_part * last.pressure + expected_units;
    const SpikeReplay::Spike spike = replay_.lost_since(index)
                                         ? replay_.hear(index, time, {last.pressure, sigma * sigma})
                                         : replay_.hear(index, time);
    // A spike that measures nothing, such as one too soon after the last, does not replace the last
    // measurement.
    if (!spike.known || !std::isfinite(spike.measured.force_n) || !(spike.measured.force_n > 0)) return;
    const double sensed = spike.measured.force_n;
    const double sensor = sensor_sigma(index, sensed);
    const double variance = spike.measured.variance_n2 + sensor * sensor;
    HysteresisBranch& branch = branches_[index];
    branch.follow(sensed, std::sqrt(variance));
    const double pressure = branch.grip_n(sensed, std::sqrt(variance));
    const double play = branch.sigma_n(sensed);
    const TimePoint at = time - rounded(Seconds(spike.measured.lag_s)) - scan_ / 2;
    const double since_s = std::max(0.0, seconds(at - last.time)) + least_interval_s;
    last.change_per_s = (pressure - last.pressure) / since_s;
    last.interval = last.pressure > 0 ? time - fired : Duration::max();
    last.pressure = pressure;
    last.variance = variance + play * play;
    last.time = at;
}

// A new change closes the one before it, whose factor becomes part of the measurements.
void FieldPressures::take_transient(std::uint32_t index, TimePoint time) noexcept {
    if (change_.begins(time)) {
        const CommonChange::Factor before = change(time);
        for (std::uint32_t i = 0; i < last_.size(); ++i) {
            const Last last = changed(i, before);
            held_[i] = is_remembered(last, time) ? last.pressure * unit_n_per_mm2_[i] : 0;
        }
        if (change_.feels(index, held_)) {
            for (std::uint32_t i = 0; i < last_.size(); ++i) last_[i] = changed(i, before);
            change_.begin(time, held_, !slides_);
        }
    }
    change_.hear(index, time);
}

CommonChange::Sustained FieldPressures::tell_change(std::uint32_t index, TimePoint until) const noexcept {
    const Last& last = last_[index];
    const TimePoint began = change_.began();
    const double held = change_.held()[index];
    const double unit = unit_n_per_mm2_[index];
    if (last.pressure > 0 && last.time >= began - CommonChange::sudden) {
        const bool after = last.time > began + CommonChange::sudden;
        const bool first = last.interval == Duration::max();
        const double rise = last.change_per_s * seconds(last.interval);
        if (after ? !(held > 0) : first || rise > least_rise * last.pressure) return {.rises = true};
        if (after) return {.held = held, .measured = last.pressure * unit};
        if (last.time >= began) return {};  // it may have been measured before the change was over
    }
    return {.held = held, .at_most = bound(index, until).pressure * unit};
}

CommonChange::Factor FieldPressures::change(TimePoint now) const noexcept {
    if (!change_.happened() || now - change_.began() > forgotten_after) return {};
    const TimePoint begin = change_.began() - CommonChange::sudden;
    const TimePoint end = change_.ended();
    const double lost = seconds(replay_.lost_between(begin, end)) / seconds(end - begin);
    const TimePoint until = std::max(known_until(now), end);
    return change_.factor(1 - lost, [&](std::uint32_t i) { return tell_change(i, until); });
}

FieldPressures::Last FieldPressures::changed(std::uint32_t index,
                                             const CommonChange::Factor& change) const noexcept {
    Last last = last_[index];
    if (change == CommonChange::Factor() || last.time >= change_.began()) return last;
    last.variance = change.mean * change.mean * last.variance + std::pow(change.sigma * last.pressure, 2);
    last.pressure *= change.mean;
    return last;
}

double FieldPressures::common_sigma(TimePoint now, const CommonChange::Factor& change) const noexcept {
    double sum = 0, before = 0;
    for (std::uint32_t i = 0; i < last_.size(); ++i) {
        if (!is_remembered(last_[i], now)) continue;
        sum += changed(i, change).pressure * unit_n_per_mm2_[i];
        if (last_[i].time < change_.began()) before += last_[i].pressure * unit_n_per_mm2_[i];
    }
    return sum > 0 ? change.sigma * before / sum : 0;
}

void FieldPressures::resume_after(TimePoint start, TimePoint heard_until) noexcept {
    counted_from_ = std::max(start, heard_until);
    heard_until_ = presumed_until_ = heard_until;
    replay_.restart(counted_from_);
    std::fill(last_.begin(), last_.end(), Last{.time = counted_from_});
    std::fill(branches_.begin(), branches_.end(), untouched_);
    change_.restart();
    slides_ = false;
}

double FieldPressures::Bound::at_most() const noexcept { return pressure + bounds_at * sigma; }

FieldPressures::Bound FieldPressures::bound(std::uint32_t index, TimePoint until) const noexcept {
    const SpikeReplay::Measurement silent = replay_.silent(index, until);
    Bound bound{silent.force_n, std::sqrt(silent.variance_n2)};
    if (std::isfinite(bound.pressure) && std::isfinite(bound.sigma))
        bound.sigma += sensor_sigma(index, bound.pressure);
    return bound.at_most() < sensing_[index].full_scale ? bound
                                                        : Bound{std::numeric_limits<double>::infinity(), 0};
}

// Afferents that are silent together tell of a fall before each of them does by itself.
double FieldPressures::change_per_s(TimePoint until, TimePoint now,
                                    const CommonChange::Factor& change) const noexcept {
    double weights = 0, squares = 0;
    double falling = 0, squares_of_falls = 0;
    for (std::uint32_t i = 0; i < last_.size(); ++i) {
        const Last last = changed(i, change);
        if (!is_remembered(last, now)) continue;
        const double age_s = seconds(now - last.time);
        const double recent = 1 - age_s / seconds(of_late);
        if (last.interval <= begins_train && recent > 0) {
            const double per_s = last.change_per_s * unit_n_per_mm2_[i];
            weights += recent * recent;
            squares += recent * recent * per_s * per_s;
        }
        const double fall = (last.pressure - bound(i, until).at_most()) / left_below;
        if (!(fall > 0)) continue;
        const double per_s = fall * unit_n_per_mm2_[i] / (age_s + least_interval_s);
        falling += 1;
        squares_of_falls += per_s * per_s;
    }
    return std::hypot(weights > 0 ? std::sqrt(squares / weights) : 0,
                      falling > 0 ? std::sqrt(squares_of_falls / falling) : 0);
}

double FieldPressures::may_have_changed(const Last& last, TimePoint now, double per_s) const noexcept {
    const double lost_s = seconds(replay_.lost_between(last.time, now));
    return last.pressure * (per_s * (seconds(now - last.time) - lost_s) + may_change_unheard_per_s * lost_s);
}

double FieldPressures::settled(const Last& last, const Bound& bound, double age_s) noexcept {
    if (last.interval <= begins_train || !std::isfinite(bound.pressure)) return last.pressure;
    return last.pressure + std::max(0.0, bound.pressure - last.pressure) * std::min(1.0, age_s / settles_s);
}

PressureFit::Reading FieldPressures::reading(std::uint32_t index, const Last& last, TimePoint until,
                                             TimePoint now, double change_per_s) const noexcept {
    const Bound bound = this->bound(index, until);
    const double least = last.pressure - (last.pressure - bound.at_most()) / left_below;
    if (!is_remembered(last, now) || (bound.at_most() < last.pressure && !(least > 0)))
        return {0, bound.pressure, bound.sigma, bound.sigma};
    const double age_s = seconds(now - last.time);
    const double sigma =
        std::hypot(std::sqrt(last.variance),
                   most_change * change_per_s * age_s + may_have_changed(last, now, may_change_per_s));
    if (last.pressure >= sensing_[index].full_scale)
        return {last.pressure, std::numeric_limits<double>::infinity(), sigma, sigma};
    if (bound.at_most() < last.pressure) return {least, std::max(least, bound.pressure), sigma, bound.sigma};
    return {last.pressure, settled(last, bound, age_s), sigma,
            std::min(sigma, std::max(0.0, bound.at_most() - last.pressure))};
}

std::uint32_t FieldPressures::read(TimePoint now, std::span<PressureFit::Reading> readings,
                                   const CommonChange::Factor& change) const noexcept {
    std::uint32_t feel = 0;
    const TimePoint until = known_until(now);
    const double per_s = change_per_s(until, now, change);
    for (std::uint32_t i = 0; i < last_.size(); ++i) {
        PressureFit::Reading& reading = readings[i];
        const double unit = unit_n_per_mm2_[i];
        reading = this->reading(i, changed(i, change), until, now, per_s / unit);
        reading.lowest *= unit;
        reading.highest *= unit;
        reading.below *= unit;
        reading.above *= unit;
        feel += reading.lowest > 0;
    }
    return feel;
}

void FieldPressures::read_at_their_times(TimePoint now, std::span<PressureFit::Reading> readings,
                                         const CommonChange::Factor& change) const noexcept {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const TimePoint until = known_until(now);
    for (std::uint32_t i = 0; i < last_.size(); ++i) {
        const Last last = changed(i, change);
        const double unit = unit_n_per_mm2_[i];
        const Bound bound = this->bound(i, until);
        readings[last_.size() + i] = {0, bound.pressure * unit, bound.sigma * unit, bound.sigma * unit,
                                      seconds(now - until)};
        readings[i] = {0, infinite, 0, 0};
        if (!is_remembered(last, now)) continue;
        const double age_s = seconds(now - last.time);
        const double sigma = unit * std::hypot(std::sqrt(last.variance),
                                               may_have_changed(last, now, changes_while_moving_per_s));
        const double highest =
            last.pressure >= sensing_[i].full_scale ? infinite : settled(last, bound, age_s);
        readings[i] = {last.pressure * unit, highest * unit, sigma, sigma, age_s};
    }
}

FieldPressures::Snapshot FieldPressures::snapshot() const {
    return {replay_.snapshot(), last_,           branches_,    change_.snapshot(), slides_,
            heard_until_,       presumed_until_, counted_from_};
}

void FieldPressures::resume(const Snapshot& snapshot) {
    require(snapshot.last.size() == last_.size() && snapshot.branches.size() == branches_.size(),
            "snapshot.last", "one for each afferent", static_cast<double>(snapshot.last.size()));
    replay_.resume(snapshot.replay);
    change_.resume(snapshot.change);
    last_ = snapshot.last;
    branches_ = snapshot.branches;
    slides_ = snapshot.slides;
    heard_until_ = snapshot.heard_until;
    presumed_until_ = snapshot.presumed_until;
    counted_from_ = snapshot.counted_from;
}

std::size_t FieldPressures::heap_bytes() const noexcept {
    return replay_.heap_bytes() + unit_n_per_mm2_.capacity() * sizeof(double) +
           sensing_.capacity() * sizeof(Sensing) + last_.capacity() * sizeof(Last) +
           branches_.capacity() * sizeof(HysteresisBranch) + change_.heap_bytes() +
           held_.capacity() * sizeof(double);
}

}  // namespace afferent
