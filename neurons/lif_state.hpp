// The state of an exact neuron, as its two forms hand it to each other.
#pragma once

#include "afferent/runtime/time.hpp"

namespace afferent {

struct LifState {
    double gap_mv;  // v_th − v
    double g;
    Interval refractory_left;
};

// From and to the state of any class of lif_models.hpp, exactly.
template <class State>
LifState to_lif_state(const State& state) noexcept {
    if constexpr (requires { state.base; }) {
        LifState all = to_lif_state(state.base);
        all.refractory_left = state.left;
        return all;
    } else if constexpr (requires { state.g; }) {
        return {state.gap_mv, state.g, Interval(0)};
    } else {
        return {state.gap_mv, 0, Interval(0)};
    }
}

template <class State>
State from_lif_state(const LifState& all) noexcept {
    if constexpr (requires(State state) { state.base; })
        return {from_lif_state<decltype(State::base)>(all), all.refractory_left};
    else if constexpr (requires(State state) { state.g; })
        return {all.gap_mv, all.g};
    else
        return {all.gap_mv};
}

}  // namespace afferent
