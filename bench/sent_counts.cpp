#include "bench/sent_counts.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace afferent {
namespace {

constexpr double highest_count = 4095;
constexpr double slope_parts = 32;    // of a band by scan, in which slopes are sent
constexpr double shortest_slope = 8;  // scans: a slope that takes longer for half a band is taken for none

}  // namespace

SentCounts::SentCounts(std::uint32_t elements, const ChangeRule& rule) : rule_(rule), states_(elements) {
    assert(rule.band > 0 && rule.fraction >= 0);
}

double SentCounts::band(double value) const noexcept {
    return std::max<double>(rule_.band, std::ceil(rule_.fraction * value));
}

void SentCounts::pass() noexcept {
    for (State& state : states_) {
        state.moved = 0;
        if (state.slope == 0) continue;
        const double next = state.value + state.slope * band(state.value) / slope_parts;
        state.value = std::clamp(next, 0.0, highest_count);
        if (next != state.value) state.slope = 0;
    }
}

void SentCounts::take(State& state, std::int32_t amount, std::int32_t slope) noexcept {
    state.step = band(state.value);
    state.value = std::clamp(state.value + amount * state.step, 0.0, highest_count);
    state.slope = slope;
    state.moved = amount;
}

// By least squares.
std::int32_t SentCounts::slope_to_send(const State& state, double band) const noexcept {
    static_assert(fitted == 4);
    const auto& [a, b, c, d] = state.recent;
    const double slope = (3.0 * (d - a) + (c - b)) / 10;
    if (std::abs(slope) * shortest_slope < band / 2) return 0;
    return static_cast<std::int32_t>(std::lround(slope / band * slope_parts));
}

void SentCounts::send(Counts scan, std::uint32_t first, std::vector<CountChange>& changes) {
    pass();
    for (std::uint32_t e = 0; e < scan.size(); ++e) {
        State& state = states_[e];
        if (rule_.linear) {
            std::shift_left(state.recent.begin(), state.recent.end(), 1);
            state.recent.back() = scan[e];
        }
        const double width = band(state.value);
        const double off = scan[e] - state.value;
        if (std::abs(off) < width) continue;
        const double steps = off / width;
        const auto amount = static_cast<std::int32_t>(levels_hold() ? std::trunc(steps) : std::round(steps));
        const std::int32_t slope = rule_.linear ? slope_to_send(state, width) : 0;
        take(state, amount, slope);
        changes.push_back({first + e, amount, slope});
    }
}

void SentCounts::receive(std::span<const CountChange> changes, std::uint32_t first) {
    pass();
    for (const auto& [element, amount, slope] : changes) take(states_[element - first], amount, slope);
}

SentCounts::Range SentCounts::range(std::uint32_t element) const noexcept {
    const State& state = states_[element];
    const double width = band(state.value);
    // A reading is rounded to whole counts. What is not sent is, in whole counts, less than a band away.
    const double within = rule_.linear ? width + 0.5 : width - 0.5;
    if (state.moved == 0) return {state.value - within, state.value + within};
    if (!levels_hold()) {
        const double rounded = state.step / 2 + 0.5;
        return {state.value - rounded, state.value + rounded};
    }
    return {state.moved > 0 ? state.value - 0.5 : state.value - within,
            state.moved < 0 ? state.value + 0.5 : state.value + within};
}

}  // namespace afferent
