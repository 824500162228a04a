// What every neuron model is: constant parameters, a separate state, and an exact flow under a held drive.
#pragma once

#include <concepts>

#include "afferent/neurons/parameters.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// A model holds what was derived from its parameters and never changes; a state is a value, and copying it is a
// snapshot. The drive is R·I in mV, held over the interval. Intervals are not negative.
//
//     rest()            v = v_r, g = 0
//     advance(s, I, dt) the flow, without a threshold: callers do not step over a spike
//     next_spike(s, I)  the span from s to the first upward crossing under a drive held for good, +infinity if none;
//                       0 if the state is at threshold already
//     fire(s)           the jump at a spike; s has been advanced to it
template <class N>
concept Neuron = requires(const N& neuron, typename N::State& state, const typename N::State& constant,
                          double drive_mv, Interval dt) {
    N(NeuronParameters{});
    { neuron.rest() } -> std::same_as<typename N::State>;
    neuron.advance(state, drive_mv, dt);
    { neuron.next_spike(constant, drive_mv) } -> std::same_as<Interval>;
    neuron.fire(state);
    { neuron.v_mv(constant) } -> std::same_as<double>;
    { neuron.g(constant) } -> std::same_as<double>;
};

}  // namespace afferent
