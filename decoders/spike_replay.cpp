#include "afferent/decoders/spike_replay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <span>

#include "afferent/decoders/silence.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// More spikes than this cannot be told apart in what was lost, nor more spans.
constexpr double most_lost_spikes = 3;
constexpr std::size_t told_apart = 4;
// The adaptation that lost spikes leave is doubted by this part of it.
constexpr double doubtful_part = 0.2;
// Fewer than these are taken for none.
constexpr double negligible_spikes = 0.05;
// A force that nobody expects may come all the same, at such a density per N.
constexpr double unexpected_per_n = 1e-3;
constexpr double any_per_n = 0.3;
constexpr double seldom = 0.1;
// Before a start in the middle of a scene an afferent has fired at up to twice this rate. Its adaptation
// swings about the mean by half of what a spike adds.
constexpr double unheard_rate_hz = 50;
// The part of the presumed adaptation that is doubted, because the grip may have begun with the start.
constexpr double held_doubt = 0.5;

// None for an interval that is too short for any force.
double density(const SpikeReplay::Measurement& measured, const SpikeReplay::Expected& expected) {
    if (!std::isfinite(measured.force_n)) return 0;
    const double variance_n2 = measured.variance_n2 + expected.variance_n2;
    const double error_n = measured.force_n - expected.force_n;
    return unexpected_per_n +
           std::exp(-error_n * error_n / (2 * variance_n2)) / std::sqrt(2 * std::numbers::pi * variance_n2);
}

}  // namespace

SpikeReplay::SpikeReplay(const DecodedAfferents& afferents, double unit_n)
    : index_of_(afferents.addresses, not_read), tick_s_(seconds(afferents.tick)) {
    afferents.check();
    groups_.reserve(afferents.groups.size());
    std::set<const IntervalTable*> tables;
    for (const DecodedAfferents::Group& group : afferents.groups) {
        const IntervalDrive drive(group.neuron);
        if (tables.insert(&drive.table()).second) table_bytes_ += drive.table().bytes();
        history_ = std::max(history_, rounded(Seconds(40 * std::max(drive.tau_g_s(), drive.tau_m_s()))));
        const bool transient = group.drive_mv_s_per_n > 0;
        const double drive_mv = transient ? group.drive_mv_s_per_n : group.drive_mv_per_n;
        const double threshold_n = drive_mv > 0 ? (rheobase_mv(group.neuron) - group.bias_mv) / drive_mv : 0;
        groups_.push_back({drive, threshold_n / unit_n, 1 / (drive_mv * unit_n), transient});
        tau_g_s_ = std::max(tau_g_s_, drive.tau_g_s());
        if (drive_mv > 0 && !transient)
            step_n_ =
                std::max(step_n_, drive.after_spike(0) * drive.excess_per_g_mv() * groups_.back().n_per_mv);
    }
    bool sustained = false;
    for (const auto& [address, group, share, patch] : afferents.afferents) {
        const bool is_sustained = afferents.groups[group].drive_mv_per_n > 0;
        if (!(share > 0 && (is_sustained || groups_[group].transient))) continue;
        sustained = sustained || is_sustained;
        if (is_sustained && !(unit_n * groups_[group].threshold_n < afferents.largest_grip_n))
            throw ParameterError(
                "patch", "patches that fire within the range of their sensors",
                "silent up to " + std::to_string(afferents.largest_grip_n) + " N of grip force");
        index_of_[address] = static_cast<std::uint32_t>(group_of_.size());
        group_of_.push_back(group);
    }
    require(sustained, "patch", "at least one patch of the sustained kind whose elements have a share", 0);
    trains_.resize(group_of_.size());
    restart(scene_start);
}

// An error of the stamps, of uniform ticks at both ends, is one of the interval: half a tick² / 3.
SpikeReplay::Measurement SpikeReplay::measurement(const Group& group, double doubt_g,
                                                  const IntervalDrive::Solution& solution) const noexcept {
    const double falls_n_per_s = solution.per_s_mv * group.n_per_mv;
    const double tick_n = falls_n_per_s * tick_s_;
    const double doubt_n = group.drive.excess_per_g_mv() * doubt_g * solution.kept * group.n_per_mv;
    return {group.threshold_n + solution.excess_mv * group.n_per_mv, solution.lag_s,
            tick_n * tick_n / 6 + doubt_n * doubt_n, falls_n_per_s};
}

SpikeReplay::Lost SpikeReplay::lost_within(const Train& train, TimePoint until) const noexcept {
    Lost lost{until, train.since, 0};
    for (std::size_t i = 0; i < losses_.count && losses_.spans[i].end > train.since; ++i) {
        const TimePoint begin = std::max(losses_.spans[i].begin, train.since);
        const TimePoint end = std::min(losses_.spans[i].end, until);
        if (begin >= end) continue;
        const double spikes = spikes_within(train, begin, end);
        if (spikes < negligible_spikes) continue;
        lost = {begin, std::max(lost.end, end), lost.spikes + spikes};
    }
    return lost;
}

// At the rate that the wait since the last spike allows; none once that is as long ago as the history.
double SpikeReplay::spikes_within(const Train& train, TimePoint begin, TimePoint end) const noexcept {
    const Duration waiting = begin - train.last;
    if (waiting >= history_) return 0;
    const double rate_hz = waiting > 0ns ? std::min(train.rate_hz, 1 / seconds(waiting)) : train.rate_hz;
    return rate_hz * seconds(end - begin);
}

void SpikeReplay::fire(Train& train, TimePoint time, double g, double doubt_g) noexcept {
    train.g = g;
    train.doubt_g = doubt_g;
    train.last = train.since = std::max(time, train.since);
}

SpikeReplay::Spike SpikeReplay::hear(std::uint32_t index, TimePoint time, const Expected& expected) noexcept {
    if (const Lost lost = lost_within(trains_[index], time); lost.spikes > 0)
        return hear_after_loss(index, time, lost, expected);
    return hear(index, time);
}

SpikeReplay::Spike SpikeReplay::hear(std::uint32_t index, TimePoint time) noexcept {
    Train& train = trains_[index];
    const Group& group = group_of(index);
    const Duration interval = std::max(time - train.since, Duration(0));
    const bool begins_with_spike = train.last == train.since;
    if (begins_with_spike && interval > 0ns && train.rate_hz == 0 && start_ != scene_start)
        presume_held(train, group.drive, interval);
    const IntervalDrive::Solution solution = group.drive.solve(train.g, interval);
    const TimePoint begin = train.since;
    // In a long silence the begin of the interval does not matter.
    const bool known = interval > 0ns && (begins_with_spike || seconds(interval) > 5 * group.drive.tau_m_s());
    const Measurement what = measurement(group, train.doubt_g, solution);
    if (begins_with_spike && interval > 0ns) train.rate_hz = 1 / seconds(interval);
    fire(train, time, group.drive.after_spike(train.g * solution.kept), train.doubt_g * solution.kept);
    return {what, begin, known};
}

SpikeReplay::Hypothesis SpikeReplay::none_lost(std::uint32_t index, TimePoint time) const noexcept {
    const Train& train = trains_[index];
    const Group& group = group_of(index);
    const IntervalDrive::Solution solution = group.drive.solve(train.g, time - train.since);
    return {measurement(group, train.doubt_g, solution), train.since, train.g * solution.kept,
            train.doubt_g * solution.kept, 1};
}

// In the middle of that span; before it as many as its last rate makes, of which each needs a span too.
SpikeReplay::Hypothesis SpikeReplay::lost_in(std::uint32_t index, const Losses::Span& span,
                                             std::size_t earlier_spans, TimePoint time) const noexcept {
    const Train& train = trains_[index];
    const Group& group = group_of(index);
    const TimePoint begin = std::max(span.begin, train.since);
    const TimePoint end = std::min(span.end, time);
    const TimePoint middle = begin + (end - begin) / 2;
    const Duration before = middle - train.since;
    const double earlier = std::clamp(std::round(seconds(before) * train.rate_hz) - 1, 0.0,
                                      std::min(static_cast<double>(earlier_spans), most_lost_spikes - 1));
    const double kept = group.drive.decayed(1, before);
    const double g_then = group.drive.after_spike(
        earlier > 0 ? group.drive.driven(train.g, before, earlier / seconds(before)) : train.g * kept);
    const double doubt_then =
        std::hypot(train.doubt_g * kept, doubtful_part * earlier * group.drive.after_spike(0));
    const IntervalDrive::Solution solution = group.drive.solve(g_then, time - middle);
    Hypothesis hypothesis{measurement(group, doubt_then, solution), middle, g_then * solution.kept,
                          doubt_then * solution.kept, 0};
    const double spread_n = solution.per_s_mv * group.n_per_mv * seconds(end - begin);
    hypothesis.measured.variance_n2 += spread_n * spread_n / 12;
    // Where in a longer span it was cannot be measured.
    const double spikes = spikes_within(train, begin, end);
    if (spikes <= 1) hypothesis.weight = std::pow(std::min(spikes, 0.9), earlier + 1);
    return hypothesis;
}

SpikeReplay::Spike SpikeReplay::hear_after_loss(std::uint32_t index, TimePoint time, Lost lost,
                                                const Expected& expected) noexcept {
    Train& train = trains_[index];
    const Group& group = group_of(index);
    if (train.last == train.since && lost.spikes <= most_lost_spikes) {
        std::array<Hypothesis, 1 + told_apart> hypotheses;
        std::size_t count = 0;
        Hypothesis& none = hypotheses[count++] = none_lost(index, time);
        none.weight = 1 - std::min(lost.spikes, 0.9);
        // Lost spikes make an interval longer than expected, never shorter.
        const bool is_long = none.measured.force_n < expected.force_n + 2 * std::sqrt(expected.variance_n2);
        std::size_t spans = 0;
        while (spans < losses_.count && losses_.spans[spans].end > train.since) ++spans;
        for (std::size_t i = 0; i < std::min(spans, told_apart); ++i) {
            if (losses_.spans[i].begin >= time) continue;
            Hypothesis& one = hypotheses[count++] = lost_in(index, losses_.spans[i], spans - 1 - i, time);
            if (!is_long) one.weight *= seldom;
        }
        double sum = 0;
        for (Hypothesis& each : std::span(hypotheses).first(count))
            sum += each.weight *= density(each.measured, expected);
        const double other = std::min(std::pow(lost.spikes, 3) / 6, 0.2) * any_per_n;
        if (sum > 0 && (!is_long || other < sum)) {
            const Hypothesis* best = &hypotheses[0];
            double force_n = 0, force_n2 = 0, g = 0, g2 = 0;
            for (const Hypothesis& each : std::span(hypotheses).first(count)) {
                if (!(each.weight > 0)) continue;
                const double part = each.weight / sum;
                force_n += part * each.measured.force_n;
                force_n2 += part * each.measured.force_n * each.measured.force_n;
                g += part * each.g;
                g2 += part * (each.g * each.g + each.doubt_g * each.doubt_g);
                if (each.weight > best->weight) best = &each;
            }
            Spike spike{best->measured, best->begin, true};
            spike.measured.variance_n2 += std::max(force_n2 - force_n * force_n, 0.0);
            train.rate_hz = 1 / seconds(time - best->begin);
            fire(train, time, group.drive.after_spike(g), std::sqrt(std::max(g2 - g * g, 0.0)));
            return spike;
        }
        // As many as there are intervals of the last length, at least.
        lost.spikes = std::max(lost.spikes, seconds(time - train.since) * train.rate_hz - 1);
    }
    const double kept = group.drive.decayed(1, time - lost.end);
    const auto [g, doubt_g] = after_loss(group, train, lost);
    fire(train, time, group.drive.after_spike(g * kept), doubt_g * kept);
    return {{}, time, false};
}

// A count is off by up to one, and by a third of the spikes as the force may have changed.
SpikeReplay::Adaptation SpikeReplay::after_loss(const Group& group, const Train& train,
                                                const Lost& lost) const noexcept {
    const Duration before = lost.begin - train.since;
    const Duration within = lost.end - lost.begin;
    const double g =
        group.drive.driven(group.drive.decayed(train.g, before), within, lost.spikes / seconds(within));
    const double doubt_g =
        group.drive.after_spike(0) * (0.3 * lost.spikes + std::min(0.4, std::sqrt(lost.spikes)));
    return {g, std::hypot(group.drive.decayed(train.doubt_g, before + within), doubt_g)};
}

// A Kalman filter's step for g alone.
void SpikeReplay::correct(std::uint32_t index, const Measurement& measured, const Expected& force) noexcept {
    Train& train = trains_[index];
    const Group& group = group_of(index);
    const double n_per_g = group.drive.excess_per_g_mv() * group.n_per_mv;
    const double gain = train.doubt_g * train.doubt_g * n_per_g / (measured.variance_n2 + force.variance_n2);
    train.g = std::max(train.g - gain * (measured.force_n - force.force_n), 0.0);
    train.doubt_g *= std::sqrt(std::max(1 - gain * n_per_g, 0.0));
}

SpikeReplay::Measurement SpikeReplay::silent(std::uint32_t index, TimePoint until) const noexcept {
    const Train& train = trains_[index];
    const Group& group = group_of(index);
    if (lost_since(index))
        if (const Lost lost = lost_within(train, until); lost.spikes > 0) {
            const auto [g, doubt_g] = after_loss(group, train, lost);
            return measurement(group, doubt_g, group.drive.solve(g, until - lost.end));
        }
    return silent_if_none_lost(index, until);
}

SpikeReplay::Measurement SpikeReplay::silent_if_none_lost(std::uint32_t index,
                                                          TimePoint until) const noexcept {
    const Train& train = trains_[index];
    const Group& group = group_of(index);
    return measurement(group, train.doubt_g, group.drive.solve(train.g, until - train.since));
}

void SpikeReplay::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    auto& [spans, count] = losses_;
    if (count > 0 && begin <= spans[0].end) {
        spans[0] = {std::min(begin, spans[0].begin), std::max(end, spans[0].end)};
        return;
    }
    count = std::min(count + 1, spans.size());
    std::move_backward(spans.begin(), spans.begin() + static_cast<std::ptrdiff_t>(count) - 1,
                       spans.begin() + static_cast<std::ptrdiff_t>(count));
    spans[0] = {begin, end};
}

Duration SpikeReplay::lost_between(TimePoint begin, TimePoint end) const noexcept {
    Duration lost{};
    for (std::size_t i = 0; i < losses_.count && losses_.spans[i].end > begin; ++i)
        lost += std::max(std::min(losses_.spans[i].end, end) - std::max(losses_.spans[i].begin, begin),
                         Duration(0));
    return lost;
}

double SpikeReplay::doubted_spikes(double tau_g_s) const noexcept {
    if (start_ == scene_start) return 0;
    if (held_hz_ > 0) return held_doubt / std::expm1(1 / (held_hz_ * tau_g_s));
    return unheard_rate_hz * tau_g_s + 0.5;
}

// Adds the adaptation that spikes at this interval have left, the last of them one interval before the first
// that was heard, or at the start if that was earlier.
void SpikeReplay::presume_held(Train& train, const IntervalDrive& drive, Duration interval) noexcept {
    const double held = drive.after_spike(0) / std::expm1(seconds(interval) / drive.tau_g_s());
    const double left = drive.decayed(held, std::max(train.since - start_ - interval, Duration(0)));
    train.g += left;
    train.doubt_g = held_doubt * left;
    held_hz_ = std::max(held_hz_, 1 / seconds(interval));
}

double SpikeReplay::unknown_since_start_n(TimePoint until) const noexcept {
    if (start_ == scene_start) return 0;
    return step_n_ * doubted_spikes(tau_g_s_) * std::exp(-seconds(until - start_) / tau_g_s_);
}

void SpikeReplay::restart(TimePoint start) noexcept {
    start_ = start;
    held_hz_ = 0;
    for (std::uint32_t i = 0; i < afferents(); ++i) {
        const IntervalDrive& drive = group_of(i).drive;
        const double doubt_g = drive.after_spike(0) * doubted_spikes(drive.tau_g_s());
        trains_[i] = {.last = never_fired, .since = start, .doubt_g = doubt_g};
    }
    losses_ = {};
}

void SpikeReplay::resume(const Snapshot& snapshot) {
    require(snapshot.trains.size() == trains_.size(), "snapshot.trains", "one for each afferent",
            static_cast<double>(snapshot.trains.size()));
    trains_ = snapshot.trains;
    losses_ = snapshot.losses;
    start_ = snapshot.start;
    held_hz_ = snapshot.held_hz;
}

std::size_t SpikeReplay::heap_bytes() const noexcept {
    return groups_.capacity() * sizeof(Group) + table_bytes_ +
           (group_of_.capacity() + index_of_.capacity()) * sizeof(std::uint32_t) +
           trains_.capacity() * sizeof(Train);
}

}  // namespace afferent
