// What every neuron model is: constant parameters, a separate state, and its flow under a held drive.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <functional>
#include <limits>

#include "afferent/runtime/time.hpp"

namespace afferent {

// A neuron holds constants derived from its Parameters and never changes. Its constructor checks the
// parameters and throws ParameterError. A state is a value; copying it is a snapshot. The drive is R·I in mV,
// held over the interval. Intervals are not negative.
//
//     rest()            v = v_r, g = 0
//     at_phase(p)       the same, with v that part of the way from v_r to v_th; p is in [0, 1)
//     advance(s, I, dt) the flow, without a threshold: callers do not step over a spike
//     next_spike(s, I)  the span from s to the next spike if the drive is held for good; `never` if there is
//                       none; 0 if the state is at threshold already
//     fire(s)           the jump at a spike; s has been advanced to it
template <class N>
concept Neuron = requires(const N& neuron, typename N::State& state, const typename N::State& constant,
                          double drive_mv, Interval dt) {
    N(typename N::Parameters{});
    { neuron.rest() } -> std::same_as<typename N::State>;
    { neuron.at_phase(drive_mv) } -> std::same_as<typename N::State>;
    neuron.advance(state, drive_mv, dt);
    { neuron.next_spike(constant, drive_mv) } -> std::same_as<Interval>;
    neuron.fire(state);
    { neuron.v_mv(constant) } -> std::same_as<double>;
    { neuron.g(constant) } -> std::same_as<double>;
};

// A neuron whose next spike is expensive to compute may offer a cheap lower bound on it, which is `never`
// only if there will be no spike. Most predictions are overtaken by the next drive, so the exact time is
// often not needed.
template <class N>
concept BoundsNextSpike = Neuron<N> &&
    requires(const N& neuron, const typename N::State& state, double drive_mv) {
    { neuron.earliest_spike(state, drive_mv) } -> std::same_as<Interval>;
};

// A neuron whose reset does not depend on v may advance and fire in one call, without computing v.
template <class N>
concept FiresAfter = Neuron<N> && requires(const N& neuron, typename N::State& state, Interval dt) {
    neuron.fire_after(state, dt);
};

// expm1 of a number that occurs again and again: a value is kept once it has been asked for twice in a row.
class RememberedExpm1 {
  public:
    double operator()(double x) noexcept {
        if (x == usual_) return expm1_of_usual_;
        const double result = std::expm1(x);
        if (x == last_) {
            usual_ = x;
            expm1_of_usual_ = result;
        }
        last_ = x;
        return result;
    }

  private:
    double usual_ = 0;
    double expm1_of_usual_ = 0;
    double last_ = 0;
};

// A neuron whose flow takes an exponential of the interval may advance with one that its population
// remembers: scans are equally far apart. The result is the same to the bit.
template <class N>
concept RemembersIntervals = Neuron<N> && requires(const N& neuron, typename N::State& state, double drive_mv,
                                                   Interval dt, RememberedExpm1& expm1) {
    neuron.advance(state, drive_mv, dt, expm1);
};

// Tells the phase in [0, 1) at which a neuron of a population begins, by its index. All begin at rest where
// there is no function. It draws the phase of an address again each time, so that no phase is stored.
using Phases = std::function<double(std::uint32_t)>;

inline constexpr Interval never{std::numeric_limits<double>::infinity()};

}  // namespace afferent
