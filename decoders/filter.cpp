#include "afferent/decoders/filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "afferent/decoders/force_rate_curves.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr Duration known_for = 40ms;  // time constant of what is known, and of the rate
constexpr Duration batch_length = 3ms;
// Silence is taken in this often. More often, and moment matching shrinks the belief by its own error.
constexpr Duration silence_step = 10ms;
// The belief is predicted in steps of this, counted from when something was last heard; between two of them
// its motions alone go on.
constexpr Duration coast = 10ms;
// So many of the afferents that have been silent for longest vote, and of those that fired last.
constexpr std::uint32_t asked = 16;
// A spike this old is still a measurement of the present force.
constexpr Duration recent = 20ms;
// For this long after a measurement, half of the afferents must agree on a bound by silence; a quarter of
// them where shares are stated to wander by more than `wandering_share`, because low bounds are common there.
constexpr double wandering_share = 0.15;
constexpr Duration agreement_for = 30ms;

// A belief that is at rest with more than this weight, and below the force at which firing begins, is 0.
constexpr double surely_at_rest = 0.8;
// A measurement is an outlier beyond this squared number of standard deviations.
constexpr double odd_misfit = 9;
// A bound contradicts the belief if it is more standard deviations below it than this.
constexpr double contradiction = 4;
// A silence bounds the force at its mean plus this many standard deviations.
constexpr double sure_of_bound = 3;
// An afferent is dead after so many steps of silence at a force at which it would have fired: 100 ms.
constexpr std::uint8_t dead_after = 10;
constexpr Duration::rep most_silences_at_once = 4;
// A spike that contradicts most others adds `odd_step` to its afferent's score, and one that agrees takes 1
// off it, so that an afferent that is wrong half of the time is rejected; so is one that is wrong six times
// in a row.
constexpr std::uint8_t odd_step = 3;
constexpr std::uint8_t rejected_from = 18;
constexpr std::uint8_t trusted_below = 6;
constexpr std::uint8_t most_contradictions = 30;
// Rejected afferents are readmitted and departures are forgotten this often, so that an estimate depends on a
// bounded past: history().
constexpr Duration afresh_every = 60s;

// Each contradiction by an afferent that is not rejected raises the estimated wandering of the shares.
constexpr double wander_growth = 1.3;
constexpr double most_wander = 400;
constexpr double wander_memory_s = 5;
// A spike that departs by more than this part of the force is not explained by gains and shares.
constexpr double most_departure = 0.5;
constexpr Duration agreed_within = 100ms;
// An element is taken to read at least this part of its share.
constexpr double least_reading = 0.1;

// The mean square innovation is a running mean over 24 measurements or silences.
constexpr double innovation_memory = 1.0 / 24;
constexpr double most_innovation = 16;
constexpr double conflict_memory = 1.0 / 16;
// Below this part of the range, unknown adaptation casts no doubt on an estimate.
constexpr double negligible_part = 0.01;
// The weight of rest where knowledge begins in the middle of a scene.
constexpr double rest_in_the_middle = 0.5;
// If more of the latest spikes than this are contradicted, the belief itself is in doubt.
constexpr double much_conflict = 0.4;
// A spike of a rejected afferent casts doubt on the estimate for this long.
constexpr Duration objection_for = 200ms;
constexpr double adaptation_memory = 1.0 / 8;
// A moving force may turn faster than any motion of the bank allows; sigma covers so many scans of it.
constexpr double scans_to_turn = 3;
constexpr double speed_memory_s = 0.1;
// A spike at full scale makes an estimate saturated for this long, which exceeds the intervals at any full
// scale.
constexpr Duration saturated_for = 200ms;

// Two sensors under one force differ by this and by this part of it, beside their noise.
constexpr double differ_n = 0.005;
constexpr double differ_part = 0.002;
// A rate of change is off by this part of it.
constexpr double speed_noise_part = 0.05;
// The typical lag of the force that a spike measures.
constexpr double usual_lag_s = 0.006;
// So many standard deviations of the hysteresis that is not modelled may keep a sensor from reading its full
// scale.
constexpr double sure_of_full_scale = 2;
// A bound of the rate of change beyond this is none.
constexpr double fastest_bound_n_per_s = 200;

// The parameters of ForceBelief hold for afferents that fire at this rate under this held force.
constexpr double unit_rate_hz = 100;
constexpr double unit_force_n = 20;

// A patch whose last spike is at most this much older than the contact still counts as loaded.
constexpr Duration unloaded_for = 1s;
// Sigma of an unheard patch, as a part of the difference between the force if it is dead and if it is
// unloaded: two sigma reach half as far again as the force of a dead patch.
constexpr double unheard_sigma = 0.75;

// Where there are more afferents than the belief can tell apart, neighbours form so many blocks; a block of m
// afferents departs with 1/m of the variance of one.
constexpr std::size_t blocks_of_crowd = 16;

constexpr TimePoint start_of(TimePoint time, Duration step) { return time - (time - scene_start) % step; }

bool feels_grip(const DecodedAfferents& afferents, const DecodedAfferents::Afferent& afferent) {
    return afferent.share > 0 && afferents.groups[afferent.group].drive_mv_per_n > 0;
}

// The force over unit_force_n at which the afferents, in the mean over their shares, fire at unit_rate_hz or
// their elements are at full scale.
double unit_of(const DecodedAfferents& afferents) {
    afferents.check();
    double shares = 0, forces_n = 0;
    for (const auto& afferent : afferents.afferents) {
        if (!feels_grip(afferents, afferent)) continue;
        const DecodedAfferents::Group& group = afferents.groups[afferent.group];
        const LifParameters& lif = lif_of(group.neuron);
        const double most_hz = lif.refractory_ms > 0 ? 500 / lif.refractory_ms : unit_rate_hz;
        const double rate_hz = std::min(unit_rate_hz, most_hz);
        const double excess_mv = drive_mv(RateKind::steady, lif, rate_hz) - lif.rheobase_mv();
        const double range_n = excess_mv / group.drive_mv_per_n * unit_rate_hz / rate_hz;
        forces_n += afferent.share * std::min(range_n, group.full_scale_n);
        shares += afferent.share;
    }
    const double unit_n = forces_n / shares / unit_force_n;
    return std::isfinite(unit_n) && unit_n > 0 ? unit_n : 1;
}

ForceBelief::Parameters motions_of(const Filter::Parameters& given, double unit_n) {
    ForceBelief::Parameters parameters = given.force;
    for (std::size_t i = 0; i < given.motion.size(); ++i) {
        ForceMotion& motion = parameters.motion[i];
        if (given.motion[i].speed_n_per_s) motion.speed_n_per_s = *given.motion[i].speed_n_per_s / unit_n;
        if (given.motion[i].drift_n2_per_s)
            motion.drift_n2_per_s = *given.motion[i].drift_n2_per_s / (unit_n * unit_n);
    }
    return parameters;
}

}  // namespace

Filter::Elements::Elements(const SpikeReplay& replay, const DecodedAfferents& afferents) {
    std::size_t sustained = 0;
    double shares = 0;
    for (const auto& afferent : afferents.afferents) {
        const std::uint32_t index = replay.index_of(afferent.address);
        if (index == SpikeReplay::not_read) continue;
        element.push_back(ForceBelief::View::of_grip);
        patch.push_back(afferent.patch);
        share.push_back(0);
        if (!feels_grip(afferents, afferent)) continue;
        share.back() = afferent.share;
        shares += afferent.share;
        ++sustained;
    }
    for (double& each : share) each /= shares;
    const Uncertainty& uncertainty = afferents.uncertainty;
    const double gain = uncertainty.gain * uncertainty.gain;
    const double wander = uncertainty.share * uncertainty.share;
    if (sustained < 2 || !(gain + wander > 0)) {
        unresolved_variance = sustained < 2 ? 0 : gain + wander;
        common_variance = gain / static_cast<double>(std::max<std::size_t>(sustained, 1));
        return;
    }
    const std::size_t blocks = sustained <= ForceBelief::most_elements ? sustained : blocks_of_crowd;
    const double in_block = static_cast<double>(sustained) / static_cast<double>(blocks);
    spread = {std::vector<double>(blocks, 0), gain / in_block, wander / in_block, uncertainty.share_time_s};
    unresolved_variance = (gain + wander) * (1 - 1 / in_block);
    std::size_t next = 0;
    for (std::uint32_t index = 0; index < element.size(); ++index) {
        if (!(share[index] > 0)) continue;
        element[index] = static_cast<std::uint32_t>(next++ * blocks / sustained);
        spread.share[element[index]] += share[index];
        common_variance += gain * share[index] * share[index];
    }
}

Filter::Filter(const Parameters& parameters, const DecodedAfferents& afferents)
    : unit_n_(unit_of(afferents)),
      replay_(afferents, unit_n_),
      elements_(replay_, afferents),
      uncertainty_(afferents.uncertainty),
      rate_(afferents.read(), known_for, false),
      delay_s_(seconds(afferents.delay)),
      lead_s_(seconds(parameters.lead)),
      largest_n_(afferents.largest_grip_n / unit_n_),
      threshold_n_(largest_n_),
      full_scale_fraction_(full_scale_fraction(afferents) *
                           std::max(1 - sure_of_full_scale * uncertainty_.hysteresis, 0.1)),
      scan_s_(seconds(afferents.scan)),
      unknown_{ForceBelief(motions_of(parameters, unit_n_), elements_.spread, largest_n_), scene_start,
               HysteresisBranch(afferents.hysteresis)},
      roster_(replay_.afferents()),
      measured_(afferents.groups.size()),
      batches_(std::max<std::size_t>(elements_.spread.share.size(), 1)),
      progress_(unknown_),
      ahead_{unknown_} {
    double squared_zeros = 0;
    std::uint32_t patches = 0;
    for (std::uint32_t i = 0; i < replay_.afferents(); ++i) {
        patches = std::max(patches, elements_.patch[i] + 1);
        if (replay_.group_of(i).transient) continue;
        threshold_n_ = std::min(threshold_n_, replay_.group_of(i).threshold_n);
        squared_zeros += 1 / (elements_.share[i] * elements_.share[i]);
        ++sustained_;
    }
    // Sigma of the mean of the elements' zeros, in newtons of grip.
    offset_n_ = uncertainty_.offset_n / unit_n_ * std::sqrt(squared_zeros) / sustained_;
    patch_fired_.resize(patches);
    for (const DecodedAfferents::Group& group : afferents.groups)
        sensing_.push_back({std::min(largest_n_, group.full_scale_n / unit_n_) * full_scale_fraction_,
                            group.noise_n / unit_n_ + differ_n, group.noise_fraction + differ_part});
    // The motions have forgotten any force by then.
    history_ = std::max<Duration>(replay_.history(), 40s) + afresh_every;
    restart(scene_start);
}

// A sample is held, and is half of that time old in the mean; a slope is that of the time before it as well.
SpikeReplay::Measurement Filter::sensed_speed(std::uint32_t index,
                                              SpikeReplay::Measurement measured) const noexcept {
    const double of_two_samples_n = std::numbers::sqrt2 * sensing_[replay_.group(index)].noise_n;
    const double sensor_n_per_s =
        of_two_samples_n / std::max(scan_s_, 1e-3) + speed_noise_part * std::abs(measured.force_n);
    measured.lag_s += scan_s_;
    measured.variance_n2 += sensor_n_per_s * sensor_n_per_s;
    return measured;
}

SpikeReplay::Measurement Filter::sensed(std::uint32_t index,
                                        SpikeReplay::Measurement measured) const noexcept {
    const Sensing& sensing = sensing_[replay_.group(index)];
    const double sensor_n = sensing.noise_n + sensing.noise_fraction * std::abs(measured.force_n);
    measured.lag_s += scan_s_ / 2;
    measured.variance_n2 +=
        sensor_n * sensor_n + elements_.unresolved_variance * measured.force_n * measured.force_n;
    return measured;
}

bool Filter::left_out(Address address) const noexcept {
    const std::uint32_t index = replay_.index_of(address);
    if (index == SpikeReplay::not_read) return false;
    const auto standing = roster_[index].standing;
    return standing == AfferentRoster::Standing::dead || standing == AfferentRoster::Standing::rejected;
}

// Silence.

std::optional<Filter::Silence> Filter::silence_of(std::uint32_t index, TimePoint until,
                                                  const Progress& progress) const noexcept {
    if (until <= replay_.train(index).since) return std::nullopt;
    const SpikeReplay::Measurement silent = sensed(index, replay_.silent(index, until));
    const double bound_n = silent.force_n + sure_of_bound * std::sqrt(silent.variance_n2);
    // A silence that allows full scale bounds nothing.
    if (!(bound_n < sensing_[replay_.group(index)].full_scale_n)) return std::nullopt;
    const double reads = reading_of(index, progress.belief);
    const ForceBelief::Moments grip = progress.belief.of_past({silent.lag_s});
    const double least_n =
        grip.mean_n - contradiction * std::sqrt(std::max(progress.innovation, 1.0) * grip.variance_n2);
    return Silence{bound_n, silent.lag_s, bound_n / reads, bound_n / reads < least_n,
                   bound_n < least_n - contradiction * normal_departure(progress) * grip.mean_n};
}

// The factor between what an element reads and its share of the force.
double Filter::reading_of(std::uint32_t index, const ForceBelief& belief) const noexcept {
    const std::uint32_t element = elements_.element[index];
    return element == ForceBelief::View::of_grip
               ? 1
               : std::max(1 + belief.of_element(element).mean_n, least_reading);
}

// The standard deviation of a departure: as the scene states it, or as the shares have been found to wander.
double Filter::normal_departure(const Progress& progress) const noexcept {
    return std::hypot(uncertainty_.gain, std::sqrt(progress.wander) * uncertainty_.share);
}

// Applies the bound that half of the afferents agree on. Afferents with a much lower bound are dead, or their
// elements have departed from their shares.
void Filter::take_silence(Progress& progress, TimePoint until) const noexcept {
    struct Bound {
        Silence silence;
        ForceBelief::View view;
    };
    std::array<Bound, asked> bounds;
    std::uint32_t count = 0;
    std::uint32_t index = roster_.first();
    for (std::uint32_t i = 0; i < asked && index != AfferentRoster::end; ++i, index = roster_.next(index))
        if (const auto silence = silence_of(index, until, progress))
            bounds[count++] = {*silence, view(index, silence->lag_s)};
    const std::uint32_t agreeing = uncertainty_.share > wandering_share ? 4 : 2;
    const std::uint32_t half =
        until - measured_at_ < agreement_for ? std::min(roster_.listed(), asked) / agreeing : 0;
    const auto agreed = bounds.begin() + half;
    const auto end = bounds.begin() + count;
    if (half < count)
        std::nth_element(bounds.begin(), agreed, end, [](const Bound& one, const Bound& other) {
            return one.silence.grip_n < other.silence.grip_n;
        });
    for (const Bound& each : std::span(bounds).first(std::min(half, count)))
        if (each.silence.departs && !each.silence.contradicts && can_depart())
            progress.belief.bound(each.silence.bound_n, each.view);
    const ForceBelief::View lowest_view = half < count ? agreed->view : ForceBelief::View();
    const double agreed_n = half < count ? agreed->silence.bound_n : largest_n_ / full_scale_fraction_;
    const ForceBelief::Moments expected = progress.belief.of_past(lowest_view);
    const double bound_n = agreed_n;
    const double excess_n = expected.mean_n - bound_n;
    if (excess_n > 0) follow_innovation(progress, excess_n * excess_n / expected.variance_n2);
    // A single afferent repeats its bound at every step, and each moment matching would lower a belief that
    // is below it already.
    const bool counts = sustained_ > 1 || excess_n > -std::sqrt(expected.variance_n2);
    progress.belief.bound(counts ? bound_n : largest_n_ / full_scale_fraction_,
                          counts ? lowest_view : ForceBelief::View());
    if (transient_ == SpikeReplay::not_read) return;
    const SpikeReplay::Measurement still = sensed_speed(transient_, replay_.silent(transient_, until));
    const double bound_n_per_s = still.force_n + 2 * std::sqrt(still.variance_n2);
    if (bound_n_per_s < fastest_bound_n_per_s) progress.belief.bound_speed(bound_n_per_s, still.lag_s);
}

void Filter::follow_innovation(Progress& progress, double squared) noexcept {
    progress.innovation += (std::min(squared, most_innovation) - progress.innovation) * innovation_memory;
}

// Marks afferents that stay silent while others measure the force as dead, or as unheard if their whole patch
// has been silent since the contact began.
void Filter::find_silent(std::uint8_t steps) noexcept {
    if (progress_.time - measured_at_ >= 2 * silence_step || !is_agreed()) return;
    std::uint32_t index = roster_.first();
    for (std::uint32_t i = 0; i < asked && index != AfferentRoster::end; ++i) {
        const std::uint32_t next = roster_.next(index);
        if (const auto silence = silence_of(index, progress_.time, progress_)) {
            AfferentRoster::Entry& entry = roster_[index];
            entry.silences =
                silence->contradicts ? static_cast<std::uint8_t>(entry.silences + steps) : std::uint8_t{0};
            if (entry.silences >= dead_after) {
                const bool patch_fired = patch_fired_[elements_.patch[index]] >=
                                         std::min(contact_since_, progress_.time - unloaded_for);
                if (!patch_fired) unheard_share_ += elements_.share[index];
                leave_out(index,
                          patch_fired ? AfferentRoster::Standing::dead : AfferentRoster::Standing::unheard);
            }
        }
        index = next;
    }
}

// Whether at least two afferents have fired lately: a single one may itself be wrong.
bool Filter::is_agreed() const noexcept {
    const std::uint32_t last = roster_.last();
    if (last == AfferentRoster::end) return false;
    const std::uint32_t before = roster_.previous(last);
    return roster_.listed() <= 2 ||
           (before != AfferentRoster::end && replay_.train(before).last >= progress_.time - agreed_within);
}

void Filter::list_unheard() noexcept {
    if (!(unheard_share_ > 0)) return;
    unheard_share_ = 0;
    for (std::uint32_t index = 0; index < roster_.size(); ++index)
        if (roster_[index].standing == AfferentRoster::Standing::unheard) listen_to(index);
}

// Time.

void Filter::settle(Progress& progress, TimePoint until) const noexcept {
    if (batched_ > 0) {
        for (std::uint32_t slot = 0; slot < batches_.size(); ++slot) {
            const Batch& batch = batches_[slot];
            const std::uint32_t element = elements_.spread.share.empty() ? ForceBelief::View::of_grip : slot;
            if (batch.weight > 0)
                progress.belief.measure(batch.force / batch.weight, {batch.lag / batch.weight, element},
                                        1 / batch.weight, batched_);
            if (batch.least_n > 0) progress.belief.bound_below(batch.least_n, {batch.least_lag_s, element});
            if (std::isfinite(batch.falls_n_per_s)) progress.belief.bound_speed_below(-batch.falls_n_per_s);
        }
        progress.branch.follow(progress.belief.mean_n(), std::sqrt(progress.belief.variance_n2()));
    }
    const auto pass = [&](TimePoint to) {
        if (to <= progress.time) return;
        const double passed_s = seconds(to - progress.time);
        progress.belief.predict(passed_s, progress.wander);
        const double speed_n_per_s = progress.belief.of_speed().mean_n;
        progress.squared_speed += (speed_n_per_s * speed_n_per_s - progress.squared_speed) *
                                  -std::expm1(-passed_s / speed_memory_s);
        progress.wander = 1 + (progress.wander - 1) * std::exp(-passed_s / wander_memory_s);
        progress.time = to;
    };
    for (TimePoint step = start_of(progress.time, silence_step) + silence_step; step <= until;
         step += silence_step) {
        pass(step);
        take_silence(progress, step);
    }
    pass(until);
}

void Filter::commit(TimePoint until) noexcept {
    const TimePoint before = progress_.time;
    settle(progress_, until);
    clear_batches();
    if (progress_.belief.at_rest() > 0.5) contact_since_ = progress_.time;
    if (start_of(before, afresh_every) != start_of(progress_.time, afresh_every)) start_afresh();
}

void Filter::clear_batches() noexcept {
    if (batched_ > 0) std::fill(batches_.begin(), batches_.end(), Batch());
    batched_ = 0;
    batch_begin_ = progress_.time;
}

// Forgets the scores of afferents and the departures of elements.
void Filter::start_afresh() noexcept {
    for (std::uint32_t index = 0; index < roster_.size(); ++index) {
        roster_[index].contradictions = 0;
        if (roster_[index].standing == AfferentRoster::Standing::rejected) listen_to(index);
    }
    progress_.belief.forget_departures();
    progress_.wander = progress_.innovation = 1;
    odd_afferents_ = rejected_ = 0;
    conflict_ = objection_ = 0;
}

// Spikes.

void Filter::take(const Event& event) noexcept {
    const std::uint32_t index = replay_.index_of(event.address);
    if (replay_.group_of(index).transient) return take_transient(index, event.time);
    if (event.time >= batch_begin_ + batch_length || batched_ == 0) commit(event.time);
    if (progress_.belief.at_rest() > 0.5) list_unheard();
    const double since_begin_s = seconds(event.time - batch_begin_);
    const auto expected = [&](double lag_s) {
        const ForceBelief::Moments past = progress_.belief.of_past(view(index, lag_s - since_begin_s));
        return SpikeReplay::Expected{past.mean_n, past.variance_n2};
    };
    TimePoint& patch_fired = patch_fired_[elements_.patch[index]];
    if (patch_fired < contact_since_) list_unheard();
    patch_fired = event.time;
    if (roster_[index].standing == AfferentRoster::Standing::dead) listen_to(index);
    const SpikeReplay::Spike spike = replay_.lost_since(index)
                                         ? replay_.hear(index, event.time, expected(usual_lag_s))
                                         : replay_.hear(index, event.time);
    if (spike.known) {
        measure(spike, index, event.time);
        if (replay_.train(index).doubt_g > 0 && replay_.afferents() > 1)
            replay_.correct(index, sensed(index, spike.measured), expected(spike.measured.lag_s));
    }
    roster_[index].silences = 0;
    if (roster_[index].standing == AfferentRoster::Standing::heard) roster_.append(index);
    if (const Duration since = event.time - searched_at_; since >= silence_step) {
        searched_at_ = event.time;
        find_silent(
            static_cast<std::uint8_t>(std::min<Duration::rep>(since / silence_step, most_silences_at_once)));
    }
}

void Filter::take_transient(std::uint32_t index, TimePoint time) noexcept {
    commit(time);
    const ForceBelief::Moments expected = progress_.belief.of_speed();
    const SpikeReplay::Spike spike = replay_.lost_since(index)
                                         ? replay_.hear(index, time, {expected.mean_n, expected.variance_n2})
                                         : replay_.hear(index, time);
    transient_ = index;
    if (!spike.known || is_repeated(spike, index, time)) return;
    const SpikeReplay::Measurement speed = sensed_speed(index, spike.measured);
    progress_.belief.measure_speed(speed.force_n, speed.lag_s, speed.variance_n2);
}

// Identical afferents of one element that fire together are one measurement.
bool Filter::is_repeated(const SpikeReplay::Spike& spike, std::uint32_t index, TimePoint time) noexcept {
    const Measured measured{spike.begin, time, elements_.element[index]};
    return std::exchange(measured_[replay_.group(index)], measured) == measured;
}

void Filter::measure(const SpikeReplay::Spike& spike, std::uint32_t index, TimePoint time) noexcept {
    const SpikeReplay::Measurement measured = sensed(index, spike.measured);
    const double full_scale_n = sensing_[replay_.group(index)].full_scale_n;
    AfferentRoster::Entry& entry = roster_[index];
    entry.saturated = !(measured.force_n < full_scale_n);
    const double force_n = entry.saturated ? full_scale_n : measured.force_n;
    if (is_repeated(spike, index, time)) return;
    const ForceBelief::View seen = view(index, measured.lag_s - seconds(time - batch_begin_));
    entry.last_n = static_cast<float>(force_n);
    if (!counts(index, force_n, measured.variance_n2, seen, time)) return;
    adaptation_n_ += (replay_.adaptation_n(index) - adaptation_n_) * adaptation_memory;
    Batch& batch = batches_[elements_.spread.share.empty() ? 0 : seen.element];
    batched_ += batch == Batch() ? 1 : 0;
    if (entry.saturated) {
        batch.least_n = std::max(batch.least_n, force_n);
        batch.least_lag_s = seen.lag_s;
    } else {
        const double weight = 1 / measured.variance_n2;
        batch.weight += weight;
        batch.force += weight * force_n;
        batch.lag += weight * seen.lag_s;
        if (sustained_ == 1) batch.falls_n_per_s = std::min(batch.falls_n_per_s, measured.falls_n_per_s);
    }
    measured_at_ = time;
}

// Whether a spike is used as a measurement. A spike that most others contradict counts against its afferent;
// until that is rejected, its element's departure is widened. Contradictions of many afferents mean that the
// shares wander.
bool Filter::counts(std::uint32_t index, double force_n, double variance_n2, const ForceBelief::View& seen,
                    TimePoint time) noexcept {
    AfferentRoster::Entry& entry = roster_[index];
    const ForceBelief::Moments expected = progress_.belief.of_past(seen);
    const double error_n = force_n - expected.mean_n;
    const bool is_low_bound = entry.saturated && error_n < 0;
    if (sustained_ > 1) {
        const bool odd = !is_low_bound && progress_.belief.misfit(force_n, seen, variance_n2) > odd_misfit;
        const bool alone = std::exchange(speaker_, index) == index;
        // If most spikes are contradicted, the belief is wrong or no afferent can be trusted.
        const bool contradicted =
            (odd || alone) && is_contradicted(index, force_n, expected.mean_n, odd, time);
        const bool trusts_others = conflict_ <= much_conflict;
        conflict_ += ((contradicted ? 1 : 0) - conflict_) * conflict_memory;
        if (contradicted) {
            contradicted_n_ = force_n;
            contradicted_at_ = time;
        }
        if (!judge(index, odd, contradicted && trusts_others)) return false;
        object(force_n, seen.lag_s, time);
        if (contradicted && trusts_others) {
            const double departs = error_n / std::max(expected.mean_n, least_reading * force_n);
            if (!can_depart() || !odd || std::abs(departs) > most_departure) return false;
            progress_.belief.widen(seen.element, departs * departs);
            return true;
        }
    }
    if (!is_low_bound) follow_innovation(progress_, error_n * error_n / (expected.variance_n2 + variance_n2));
    return true;
}

// Notes a force that is further above the belief than the stated departures allow: the other afferents may be
// dead.
void Filter::object(double force_n, double lag_s, TimePoint time) noexcept {
    const ForceBelief::Moments grip = progress_.belief.of_past({lag_s});
    const double normal = std::hypot(uncertainty_.gain, uncertainty_.share);
    const double most_n =
        grip.mean_n * (1 + contradiction * normal) + contradiction * std::sqrt(grip.variance_n2);
    const bool objects = force_n > most_n;
    objection_ += ((objects ? 1 : 0) - objection_) * conflict_memory;
    if (!objects) return;
    contradicted_n_ = force_n;
    contradicted_at_ = time;
}

// Updates the score of an afferent; returns whether it is listened to.
bool Filter::judge(std::uint32_t index, bool odd, bool contradicted) noexcept {
    AfferentRoster::Entry& entry = roster_[index];
    const std::uint8_t before = entry.contradictions;
    if (contradicted)
        entry.contradictions = std::min<std::uint8_t>(entry.contradictions + odd_step, most_contradictions);
    else if (!odd && entry.contradictions > 0)
        --entry.contradictions;
    odd_afferents_ += (entry.contradictions > 0 ? 1 : 0) - (before > 0 ? 1 : 0);
    const bool was_rejected = entry.standing == AfferentRoster::Standing::rejected;
    if (entry.contradictions >= (was_rejected ? trusted_below : rejected_from)) {
        if (!was_rejected) leave_out(index, AfferentRoster::Standing::rejected);
        return false;
    }
    if (was_rejected) listen_to(index);
    if (contradicted && can_depart() && 3 * odd_afferents_ >= roster_.listed()) {
        const double grown = std::min(progress_.wander * wander_growth, most_wander);
        progress_.belief.loosen(grown - progress_.wander);
        progress_.wander = grown;
    }
    return true;
}

// Whether each afferent has a departure of its own.
bool Filter::can_depart() const noexcept {
    return !elements_.spread.share.empty() && !(elements_.unresolved_variance > 0);
}

void Filter::leave_out(std::uint32_t index, AfferentRoster::Standing standing) noexcept {
    roster_.remove(index, standing);
    rejected_ += standing == AfferentRoster::Standing::rejected;
    if (can_depart()) progress_.belief.exclude(elements_.element[index]);
}

void Filter::listen_to(std::uint32_t index) noexcept {
    if (roster_[index].standing == AfferentRoster::Standing::heard) return;
    rejected_ -= roster_[index].standing == AfferentRoster::Standing::rejected;
    roster_.prepend(index);
    roster_[index].silences = 0;
    if (can_depart()) progress_.belief.include(elements_.element[index]);
}

// Whether most other afferents vote against a spike. Those that have just fired vote for the nearer of the
// claimed and the believed force; silent ones vote against a claimed force at which they would have fired. An
// afferent whose silence contradicts the belief as well may be dead and has no vote on an outlier. If only
// this afferent has spoken of late, all have a vote.
bool Filter::is_contradicted(std::uint32_t index, double force_n, double expected_n, bool odd,
                             TimePoint time) const noexcept {
    const double reads = reading_of(index, progress_.belief);
    const double claimed_n = force_n / reads;
    const double believed_n = expected_n / reads;
    int with = 1;
    int against = 0;
    std::uint32_t other = roster_.last();
    for (std::uint32_t i = 0; i < asked && other != AfferentRoster::end;
         ++i, other = roster_.previous(other)) {
        if (other == index) continue;
        if (replay_.train(other).last < time - agreed_within) break;
        const double others_n = roster_[other].last_n / reading_of(other, progress_.belief);
        if (!odd || std::abs(others_n - claimed_n) < std::abs(others_n - believed_n))
            ++with;
        else if (replay_.train(other).last >= time - recent)
            ++against;
    }
    other = roster_.first();
    for (std::uint32_t i = 0; i < asked && other != AfferentRoster::end; ++i, other = roster_.next(other)) {
        if (other == index || (odd && roster_[other].silences > 0)) continue;
        if (replay_.train(other).last >= time - agreed_within) break;
        const auto silence = silence_of(other, time, progress_);
        if (silence && silence->grip_n < claimed_n * (1 - sure_of_bound * normal_departure(progress_)))
            ++against;
    }
    return against > with;
}

void Filter::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    ahead_.known = false;
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
    ahead_.known = false;
    const TimePoint known_until = std::min(begin, heard_until());
    commit(known_until);
    take_silence(progress_, known_until);
    lost_ = {known_until, end};
    rate_.lose(begin, end);
    replay_.lose(begin, end);
    progress_.belief.predict(seconds(end - progress_.time), progress_.wander);
    progress_.time = std::max(progress_.time, end);
    clear_batches();
}

// Whether all afferents that have fired lately are at full scale, and none has fallen silent since.
bool Filter::is_saturated(TimePoint until) const noexcept {
    bool saturated = false;
    std::uint32_t index = roster_.last();
    for (std::uint32_t i = 0; i < asked && index != AfferentRoster::end;
         ++i, index = roster_.previous(index)) {
        if (replay_.train(index).last < until - saturated_for) break;
        if (!roster_[index].saturated) return false;
        const double full_scale_n = sensing_[replay_.group(index)].full_scale_n;
        const SpikeReplay::Measurement silent = replay_.silent(index, until);
        if (silent.force_n + sure_of_bound * std::sqrt(silent.variance_n2) < full_scale_n) return false;
        saturated = true;
    }
    return saturated;
}

Estimate Filter::estimate(TimePoint now) noexcept {
    const ExponentialRate::At at = rate_.at(now);
    if (!(at.window_s() > 0)) {
        last_.sigma_n = largest_n_ * unit_n_;
        last_.doubt = Doubt::unknown;
        return last_;
    }
    const ExponentialRate::Snapshot& known = rate_.snapshot();
    const TimePoint until = std::min(now, std::max(known.heard_until, known.presumed_until));
    const bool is_lost = until <= lost_.end;
    look_ahead(until, until + (now - until) / coast * coast, is_lost);
    const std::uint32_t left_out = sustained_ - roster_.listed() - unheard();
    last_ = {.rate_hz = at.events() / at.known_s() / replay_.afferents(), .left_out = left_out};
    convert_ahead(seconds(now - ahead_.time), is_lost ? lost_.begin : until);
    return last_;
}

// Until something is heard, estimates within `coast` differ by nothing but the passing of time.
void Filter::look_ahead(TimePoint until, TimePoint time, bool is_lost) noexcept {
    if (ahead_.known && ahead_.until == until && ahead_.time == time && ahead_.is_lost == is_lost) return;
    Progress& progress = ahead_.progress;
    progress = progress_;
    settle(progress, until);
    if (!is_lost) take_silence(progress, until);
    progress.belief.predict(seconds(time - progress.time), progress.wander);
    const TimePoint heard = is_lost ? lost_.begin : until;
    ahead_.until = until;
    ahead_.time = time;
    ahead_.is_lost = is_lost;
    ahead_.silent_n = silent_below_n(progress, heard);
    ahead_.is_saturated = is_saturated(heard);
    ahead_.known = true;
}

// From the sensed force to the grip force in newtons, with everything that is not known of it.
void Filter::convert_ahead(double passed_s, TimePoint until) noexcept {
    const Progress& progress = ahead_.progress;
    const ForceBelief::Moments believed = progress.belief.after(passed_s);
    double force_n = believed.mean_n;
    double variance_n2 = believed.variance_n2 * std::max(progress.innovation, 1.0);
    const double believed_n = std::sqrt(variance_n2);
    const auto add = [&](double sigma_n) { variance_n2 += sigma_n * sigma_n; };
    const double silent_n = ahead_.silent_n;
    // A release known by silence alone may have ended anywhere below the bound, and so may a force at rest.
    // Adaptation raises that bound.
    if (force_n < threshold_n_) {
        add(force_n);
        add(silent_n / 2);
        if (progress.belief.at_rest() > surely_at_rest) force_n = 0;
    } else if (until - measured_at_ > silence_step && silent_n > force_n)
        add(std::sqrt(progress.belief.releasing()) * (silent_n - force_n) / 2);
    add(progress.branch.sigma_n(force_n));
    force_n = progress.branch.grip_n(force_n, believed_n);
    variance_n2 += std::max(elements_.common_variance, departed(progress.belief)) * force_n * force_n;
    add(scans_to_turn * scan_s_ * std::sqrt(progress.squared_speed));
    add(uncertainty_.common_gain * force_n);
    add(uncertainty_.hysteresis * force_n);
    add(uncertainty_.adaptation * std::min(adaptation_n_, force_n));
    add(offset_n_);
    const double unknown_n = replay_.unknown_since_start_n(until);
    add(unknown_n);
    if (unknown_n > std::max(SpikeReplay::well_known * force_n, negligible_part * largest_n_))
        last_.doubt = Doubt::slow;
    if (unheard_share_ > 0 && force_n > 0) {
        const double of_dead_n = force_n;
        force_n *= 1 - unheard_share_;
        add(unheard_sigma * (of_dead_n - force_n));
        last_.doubt = Doubt::unheard;
    }
    // A single rejected afferent is taken for faulty; several may be right.
    const bool several_object =
        rejected_ > std::max(1U, sustained_ / 8) && until - contradicted_at_ < objection_for;
    if (2 * last_.left_out > sustained_ || std::max(conflict_, objection_) > much_conflict ||
        several_object) {
        last_.doubt = Doubt::contradicted;
        add(std::max(contradicted_n_ - force_n, 0.0) / 2);
    }
    if (ahead_.is_saturated) {
        last_.doubt = Doubt::saturated;
        const double read_n = sensing_[replay_.group(roster_.last())].full_scale_n / full_scale_fraction_;
        force_n = std::max(force_n, read_n);
        add(force_n / 2);
    }
    last_.force_n = std::min(force_n, largest_n_) * unit_n_;
    last_.sigma_n = std::min(std::sqrt(variance_n2), largest_n_) * unit_n_;
    if (!(delay_s_ + lead_s_ > 0)) return;
    const ForceBelief::Moments sampled = progress.belief.of_past({});
    const auto later = [&](double by_s, double least_change_n) -> ExpectedForce {
        const ForceBelief::Moments then = progress.belief.of_past({-by_s});
        const double expected_n = force_n + std::max(then.mean_n - sampled.mean_n, least_change_n);
        const double expected_n2 = variance_n2 + std::max(then.variance_n2 - sampled.variance_n2, 0.0);
        return {std::clamp(expected_n, 0.0, largest_n_) * unit_n_,
                std::min(std::sqrt(expected_n2), largest_n_) * unit_n_};
    };
    // A force at rest stays 0.
    if (delay_s_ > 0 && force_n > 0) {
        // The prediction does not lower a doubtful estimate.
        const ExpectedForce now = later(delay_s_, last_.doubt == Doubt::none ? -force_n : 0);
        last_.force_n = now.force_n;
        last_.sigma_n = now.sigma_n;
    }
    if (lead_s_ > 0) last_.coming = later(delay_s_ + lead_s_, last_.force_n / unit_n_ - force_n);
}

// The bound by silence that half of the afferents agree on: those whose element is dead have a lower one.
double Filter::silent_below_n(const Progress& progress, TimePoint until) const noexcept {
    std::array<double, asked> bounds;
    std::uint32_t count = 0;
    std::uint32_t index = roster_.first();
    for (std::uint32_t i = 0; i < asked && index != AfferentRoster::end; ++i, index = roster_.next(index))
        if (const auto silence = silence_of(index, until, progress)) bounds[count++] = silence->grip_n;
    if (count == 0) return largest_n_;
    const auto agreed = bounds.begin() + count / 2;
    std::nth_element(bounds.begin(), agreed, bounds.begin() + count);
    return std::min(*agreed, largest_n_);
}

// The variance of the mean gain as the elements' departures show it, which may be more than was stated.
double Filter::departed(const ForceBelief& belief) const noexcept {
    double sum = 0;
    std::uint32_t count = 0;
    if (!can_depart()) return 0;
    for (std::uint32_t index = 0; index < roster_.size(); ++index) {
        if (roster_[index].standing != AfferentRoster::Standing::heard) continue;
        const double mean = belief.of_element(elements_.element[index]).mean_n;
        sum += mean * mean;
        ++count;
    }
    return count > 1 ? sum / (count - 1) / count : 0;
}

std::uint32_t Filter::unheard() const noexcept {
    if (!(unheard_share_ > 0)) return 0;
    std::uint32_t count = 0;
    for (std::uint32_t index = 0; index < roster_.size(); ++index)
        count += roster_[index].standing == AfferentRoster::Standing::unheard;
    return count;
}

void Filter::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) noexcept {
    const TimePoint begin = std::max(start, heard_until);
    ahead_.known = false;
    rate_.resume(start, heard_until);
    replay_.restart(begin);
    roster_.clear();
    for (std::uint32_t i = 0; i < roster_.size(); ++i)
        if (!replay_.group_of(i).transient) roster_.append(i);
    std::fill(measured_.begin(), measured_.end(), Measured{begin, begin, ForceBelief::View::of_grip});
    std::fill(patch_fired_.begin(), patch_fired_.end(), begin - unloaded_for);
    std::fill(batches_.begin(), batches_.end(), Batch());
    batched_ = 0;
    lost_ = {begin, begin};
    progress_ = unknown_;
    if (begin != scene_start) progress_.belief.presume_rest(rest_in_the_middle);
    contradicted_at_ = begin - objection_for;
    progress_.time = batch_begin_ = measured_at_ = searched_at_ = contact_since_ = span_begin_ = begin;
    transient_ = speaker_ = SpikeReplay::not_read;
    odd_afferents_ = rejected_ = 0;
    conflict_ = objection_ = contradicted_n_ = adaptation_n_ = unheard_share_ = 0;
    last_ = last;
}

Filter::Snapshot Filter::snapshot() const {
    return {rate_.snapshot(),
            replay_.snapshot(),
            roster_.snapshot(),
            patch_fired_,
            measured_,
            batches_,
            batch_begin_,
            batched_,
            progress_,
            measured_at_,
            searched_at_,
            contact_since_,
            span_begin_,
            lost_,
            transient_,
            speaker_,
            odd_afferents_,
            rejected_,
            contradicted_at_,
            conflict_,
            objection_,
            contradicted_n_,
            adaptation_n_,
            unheard_share_,
            last_};
}

void Filter::resume(const Snapshot& snapshot) {
    require(snapshot.roster.size() == roster_.size() + 1 && snapshot.measured.size() == measured_.size() &&
                snapshot.batches.size() == batches_.size(),
            "snapshot.roster", "one for each afferent and one more",
            static_cast<double>(snapshot.roster.size()));
    ahead_.known = false;
    replay_.resume(snapshot.replay);
    rate_.resume(snapshot.rate);
    roster_.resume(snapshot.roster);
    patch_fired_ = snapshot.patch_fired;
    measured_ = snapshot.measured;
    batches_ = snapshot.batches;
    batch_begin_ = snapshot.batch_begin;
    batched_ = snapshot.batched;
    progress_ = snapshot.progress;
    measured_at_ = snapshot.measured_at;
    searched_at_ = snapshot.searched_at;
    contact_since_ = snapshot.contact_since;
    span_begin_ = snapshot.span_begin;
    lost_ = snapshot.lost;
    transient_ = snapshot.transient;
    speaker_ = snapshot.speaker;
    odd_afferents_ = snapshot.odd_afferents;
    conflict_ = snapshot.conflict;
    objection_ = snapshot.objection;
    rejected_ = snapshot.rejected;
    contradicted_at_ = snapshot.contradicted_at;
    contradicted_n_ = snapshot.contradicted_n;
    adaptation_n_ = snapshot.adaptation_n;
    unheard_share_ = snapshot.unheard_share;
    last_ = snapshot.last;
}

std::size_t Filter::bytes() const noexcept {
    return sizeof(*this) + rate_.heap_bytes() + replay_.heap_bytes() + roster_.heap_bytes() +
           elements_.heap_bytes() + patch_fired_.capacity() * sizeof(TimePoint) +
           measured_.capacity() * sizeof(Measured) + batches_.capacity() * sizeof(Batch) +
           sensing_.capacity() * sizeof(Sensing) + 3 * progress_.belief.heap_bytes();
}

}  // namespace afferent
