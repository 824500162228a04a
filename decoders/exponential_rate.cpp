#include "afferent/decoders/exponential_rate.hpp"

#include <cassert>
#include <numbers>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// A known part of the kernel below this, 21 time constants after the last span, counts as nothing known.
constexpr double negligible = 1e-9;

}  // namespace

ExponentialRate::ExponentialRate(std::vector<bool> read, Duration time_constant, bool each)
    : read_(std::move(read)),
      time_constant_(time_constant),
      tau_ns_(static_cast<double>(time_constant.count())),
      as_known_as_(rounded(Seconds(std::numbers::sqrt2 * seconds(time_constant)))) {
    require(time_constant > 0ns, "time_constant_ms", "> 0", Milliseconds(time_constant).count());
    state_.each.resize(each ? read_.size() : 0);
    resume(scene_start, scene_start);
}

// Moves on to `until`: the time up to there is known or not.
void ExponentialRate::pass(Known& known, TimePoint until, bool is_known) const noexcept {
    if (until <= known.time) return;
    const auto x = static_cast<double>((until - known.time).count()) / tau_ns_;
    const double kept = std::exp(-x);
    if (is_known != known.last) {
        known.boundaries += 1;
        known.since = known.time;
    }
    known.boundaries *= kept * kept;
    known.weight = known.weight * kept + (is_known ? -std::expm1(-x) : 0);
    known.last = is_known;
    known.time = until;
}

// Marks the time from `from` to known.time, which counted as known, as unknown.
void ExponentialRate::take_back(Known& known, TimePoint from) const noexcept {
    if (!known.last || from >= known.time) return;
    const TimePoint begin = std::max(from, known.since);
    const auto x = static_cast<double>((known.time - begin).count()) / tau_ns_;
    const double boundary = std::exp(-2 * x);
    known.weight = std::max(0.0, known.weight + std::expm1(-x));
    known.boundaries =
        begin > known.since ? known.boundaries + boundary : std::max(0.0, known.boundaries - boundary);
    known.since = begin;
    known.last = false;
}

void ExponentialRate::add(Count& count, TimePoint time) const noexcept {
    count.spikes = count.spikes * decay(time - count.time) + 1;
    count.time = std::max(count.time, time);
}

void ExponentialRate::observe(TimePoint begin, TimePoint end, std::span<const Event> events) noexcept {
    if (begin > state_.heard_until) lose(state_.heard_until, begin);
    for (const Event& event : events) {
        assert(event.address < read_.size());
        if (!read_[event.address] || event.time < state_.counted_from) continue;
        add(state_.all, event.time);
        if (!state_.each.empty()) add(state_.each[event.address], event.time);
    }
    pass(state_.known, end, true);
    state_.heard_until = std::max(state_.heard_until, end);
}

void ExponentialRate::lose(TimePoint begin, TimePoint end) noexcept {
    if (begin >= end) return;
    take_back(state_.known, begin);
    pass(state_.known, end, false);
    state_.counted_from = std::max(state_.counted_from, end);
    state_.heard_until = std::max(state_.heard_until, end);
}

void ExponentialRate::resume(TimePoint start, TimePoint heard_until) noexcept {
    state_.heard_until = state_.presumed_until = heard_until;
    state_.counted_from = std::max(start, heard_until);
    state_.known = {.time = state_.counted_from, .since = state_.counted_from};
    state_.all = {.time = start};
    std::fill(state_.each.begin(), state_.each.end(), Count{.time = start});
}

ExponentialRate::At ExponentialRate::at(TimePoint now) const noexcept {
    now = std::max(now, state_.known.time);
    Known known = state_.known;
    pass(known, std::min(now, state_.presumed_until), true);
    const double since = decay(now - known.time);
    const double weight = known.weight * since;
    const double steps = 1 + known.boundaries * since * since;
    const double known_s = weight * seconds(time_constant_);
    const double window_s = weight > negligible ? known_s * std::sqrt(2 / steps) : 0;
    return {*this, now, known_s, window_s};
}

void ExponentialRate::resume(const Snapshot& snapshot) {
    require(snapshot.each.size() == state_.each.size(), "snapshot.each", "one count for each address",
            static_cast<double>(snapshot.each.size()));
    state_ = snapshot;
}

std::size_t ExponentialRate::heap_bytes() const noexcept {
    return state_.each.capacity() * sizeof(Count) + read_.capacity() / 8;
}

}  // namespace afferent
