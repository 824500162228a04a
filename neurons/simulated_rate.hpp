// Rates, rheobase and drives of any neuron, from its simulated spikes: for models without closed forms.
#pragma once

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>

#include "afferent/neurons/neuron.hpp"
#include "afferent/neurons/parameters.hpp"

namespace afferent {

namespace detail {

// Advances to the next spike and over it; false if there is none.
template <Neuron N>
bool pass_spike(const N& neuron, typename N::State& state, double drive_mv, Interval& span) {
    if constexpr (requires { neuron.advance_to_spike(state, drive_mv); }) {
        span = neuron.advance_to_spike(state, drive_mv);
    } else {
        span = neuron.next_spike(state, drive_mv);
        if (span != never) neuron.advance(state, drive_mv, span);
    }
    if (span == never) return false;
    neuron.fire(state);
    return true;
}

inline constexpr int most_spikes = 1'000'000;

// Where states can be compared, the spikes repeat sooner or later, and one round of them gives the mean
// (Brent's search for a cycle: the state to compare with moves on after 1, 2, 4, ... spikes). Otherwise until
// the interval has settled.
template <Neuron N>
Interval steady_interval(const N& neuron, typename N::State state, double drive_mv) {
    Interval span{};
    if constexpr (std::equality_comparable<typename N::State>) {
        typename N::State mark = state;
        Interval since_mark{};
        int spikes = 0;
        for (int until_move = 1, passed = 0; passed < most_spikes; ++passed) {
            if (!pass_spike(neuron, state, drive_mv, span)) return never;
            since_mark += span;
            ++spikes;
            if (state == mark) break;
            if (spikes < until_move) continue;
            mark = state;
            until_move *= 2;
            if (passed + until_move >= most_spikes) break;
            since_mark = Interval(0);
            spikes = 0;
        }
        return since_mark / spikes;
    } else {
        Interval before = never;
        for (int passed = 0; passed < most_spikes; ++passed) {
            if (!pass_spike(neuron, state, drive_mv, span)) return never;
            if (std::abs((span - before).count()) <= 1e-14 * span.count()) break;
            before = span;
        }
        return span;
    }
}

}  // namespace detail

template <Neuron N>
double simulated_rate_hz(RateKind kind, const N& neuron, double drive_mv) {
    typename N::State state = neuron.rest();
    Interval span{};
    if (!detail::pass_spike(neuron, state, drive_mv, span)) return 0;
    const Interval interval = kind == RateKind::steady ? detail::steady_interval(neuron, state, drive_mv)
                                                       : neuron.next_spike(state, drive_mv);
    return interval == never ? 0 : 1000 / Milliseconds(interval).count();
}

// The highest drive, to the last bit, at which the resting neuron never fires. It does not fire at 0.
template <Neuron N>
double simulated_rheobase_mv(const N& neuron) {
    const auto fires = [&](double drive_mv) { return neuron.next_spike(neuron.rest(), drive_mv) != never; };
    double low = 0;
    double high = 1;
    while (!fires(high)) {
        low = high;
        high *= 2;
        if (!std::isfinite(high)) return high;
    }
    for (;;) {
        const double middle = low + (high - low) / 2;
        if (!(middle > low && middle < high)) return low;
        (fires(middle) ? high : low) = middle;
    }
}

// The lowest drive at which rate_of(drive) >= rate_hz > 0, within 1e-6 of itself. rate_of does not decrease,
// may have steps, and is 0 where the drive is 0. +infinity if it stays below up to 1e9 mV.
template <class RateOf>
double lowest_drive_mv(RateOf&& rate_of, double rate_hz) {
    // A step that meets the rate exactly counts as above it: the search goes on to the foot of the step.
    const auto miss = [&](double drive_mv) {
        const double over = rate_of(drive_mv) - rate_hz;
        return over >= 0 ? std::max(over, rate_hz * std::numeric_limits<double>::epsilon()) : over;
    };
    double low = 0;
    double high = 1;
    while (miss(high) < 0) {
        low = high;
        high *= 2;
        if (high > 1e9) return std::numeric_limits<double>::infinity();
    }
    std::uintmax_t iterations = 200;
    return boost::math::tools::toms748_solve(miss, low, high, boost::math::tools::eps_tolerance<double>(22),
                                             iterations)
        .second;
}

}  // namespace afferent
