// The leaky integrate-and-fire neuron with spike-triggered adaptation, solved exactly.
//
// The files that make it, and when each is used:
//   membrane.hpp        converts drive, voltage and time to the variables of the solution; always
//   short_interval.hpp  the solution as a power series, over intervals in which g decays little: advance()
//                       and next_spike() try a few of them first, as most intervals are short
//   propagator.hpp      the solution over an interval of any length; used if the series needs too many
//                       intervals or does not converge, and for crossings that lie far ahead
//   refractory.hpp      wraps this neuron if there is a refractory period
//   earliest_spike()    needs none of them: a lower bound in closed form, by which the event queue schedules
//                       a neuron that need not be solved yet
#pragma once

#include "afferent/neurons/membrane.hpp"
#include "afferent/neurons/neuron.hpp"

namespace afferent {

// The equations of LifParameters, in the variables of Membrane. Under a held drive v falls at most once and
// then rises for good. So there is at most one upward crossing, however long the interval and however stiff
// the parameters, and no spike can be missed.
class AdaptingLif {
  public:
    using Parameters = LifParameters;
    struct State {
        double gap_mv;  // v_th − v
        double g;
    };

    // Throws ParameterError, also if there is a refractory period, which Refractory adds.
    explicit AdaptingLif(const LifParameters& parameters);

    // The same neuron with another threshold, which lies above v_r and E_k, and another Δg.
    AdaptingLif varied(double v_th_mv, double delta_g) const noexcept;

    State rest() const noexcept { return {membrane_.reset_gap_mv(), 0}; }
    State at_phase(double phase) const noexcept { return {membrane_.reset_gap_mv() * (1 - phase), 0}; }
    void advance(State& state, double drive_mv, Interval dt) const noexcept {
        RememberedExpm1 expm1;
        advance(state, drive_mv, dt, expm1);
    }
    void advance(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept;
    Interval next_spike(const State& state, double drive_mv) const noexcept;
    // The spike if g were as small from now on as it will be at the horizon, or the horizon if that is
    // earlier.
    Interval earliest_spike(const State& state, double drive_mv) const noexcept;
    void fire(State& state) const noexcept { state = {membrane_.reset_gap_mv(), state.g + delta_g_}; }
    void fire_after(State& state, Interval dt) const noexcept {
        hold(state, dt);
        fire(state);
    }
    // Lets the interval pass with v clamped; g decays.
    void hold(State& state, Interval dt) const noexcept;

    double v_mv(const State& state) const noexcept { return membrane_.v_mv(state.gap_mv); }
    double g(const State& state) const noexcept { return state.g; }

  private:
    void flow(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept;
    bool within_bounds(const State& before, double drive_mv, const State& after) const noexcept;
    double crossing(double gap_mv, double g, double excess_mv) const noexcept;
    double far_crossing(double gap_mv, double g, double excess_mv) const noexcept;

    Membrane membrane_;
    double a_;  // tau_g/tau_m
    double e_k_mv_;
    double reversal_mv_;  // W = v_th − E_k
    double delta_g_;
    double horizon_;          // in units of tau_m
    double kept_at_horizon_;  // the factor by which g decays until then
};

}  // namespace afferent
