// A neuron with an absolute refractory period: after each spike v stays at v_r for that time while g decays.
#pragma once

#include <algorithm>

#include "afferent/neurons/neuron.hpp"

namespace afferent {

// Base remembers intervals and has hold(state, dt), which lets the interval pass with v clamped, and
// parameters with refractory_ms.
// The wrapper is a class of its own, so that neurons without a refractory period pay nothing for it.
template <Neuron Base>
class Refractory {
  public:
    using Parameters = typename Base::Parameters;
    struct State {
        typename Base::State base;
        Interval left;  // of the refractory period
    };

    explicit Refractory(const Parameters& parameters)
        : base_(without_period(parameters)), period_(Milliseconds(parameters.refractory_ms)) {
        parameters.check();
    }

    State rest() const noexcept { return {base_.rest(), Interval(0)}; }
    State at_phase(double phase) const noexcept { return {base_.at_phase(phase), Interval(0)}; }

    void advance(State& state, double drive_mv, Interval dt) const noexcept {
        RememberedExpm1 expm1;
        advance(state, drive_mv, dt, expm1);
    }
    void advance(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept {
        const Interval held = std::min(dt, state.left);
        if (held > Interval(0)) {
            base_.hold(state.base, held);
            state.left -= held;
            dt -= held;
        }
        if (dt > Interval(0)) base_.advance(state.base, drive_mv, dt, expm1);
    }

    Interval next_spike(const State& state, double drive_mv) const noexcept {
        return state.left + base_.next_spike(released(state), drive_mv);
    }

    Interval earliest_spike(const State& state,
                            double drive_mv) const noexcept requires BoundsNextSpike<Base> {
        return state.left + base_.earliest_spike(released(state), drive_mv);
    }

    void fire(State& state) const noexcept {
        base_.fire(state.base);
        state.left = period_;
    }

    void fire_after(State& state, Interval dt) const noexcept requires FiresAfter<Base> {
        base_.fire_after(state.base, dt);
        state.left = period_;
    }

    double v_mv(const State& state) const noexcept { return base_.v_mv(state.base); }
    double g(const State& state) const noexcept { return base_.g(state.base); }

  private:
    static Parameters without_period(Parameters parameters) {
        parameters.refractory_ms = 0;
        return parameters;
    }

    // The state at the end of the period.
    typename Base::State released(const State& state) const noexcept {
        typename Base::State base = state.base;
        if (state.left > Interval(0)) base_.hold(base, state.left);
        return base;
    }

    Base base_;
    Interval period_;
};

}  // namespace afferent
