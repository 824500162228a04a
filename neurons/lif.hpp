// The leaky integrate-and-fire neuron without adaptation.
#pragma once

#include "afferent/neurons/membrane.hpp"
#include "afferent/neurons/neuron.hpp"

namespace afferent {

//     z(s) = z₀ e^(−s) − c (1 − e^(−s)),      a spike where z = 0: s = log(1 + z₀/c)
class Lif {
  public:
    using Parameters = LifParameters;
    struct State {
        double gap_mv;  // v_th − v
    };

    // Throws ParameterError, also if there is adaptation or a refractory period, which other classes have.
    explicit Lif(const LifParameters& parameters);

    State rest() const noexcept { return {membrane_.reset_gap_mv()}; }
    State at_phase(double phase) const noexcept { return {membrane_.reset_gap_mv() * (1 - phase)}; }
    void advance(State& state, double drive_mv, Interval dt) const noexcept {
        RememberedExpm1 expm1;
        advance(state, drive_mv, dt, expm1);
    }
    void advance(State& state, double drive_mv, Interval dt, RememberedExpm1& expm1) const noexcept;
    Interval next_spike(const State& state, double drive_mv) const noexcept;
    void fire(State& state) const noexcept { state = rest(); }
    void fire_after(State& state, Interval) const noexcept { fire(state); }
    void hold(State&, Interval) const noexcept {}  // v is clamped, and there is no other state

    double v_mv(const State& state) const noexcept { return membrane_.v_mv(state.gap_mv); }
    double g(const State&) const noexcept { return 0; }

  private:
    Membrane membrane_;
};

}  // namespace afferent
