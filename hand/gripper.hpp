// The motor, and the object between the fingers.
#pragma once

#include "afferent/runtime/time.hpp"

namespace afferent {

// A motor with a first-order lag that slows as the force rises and does not give way at rest; a compliant
// object.
//
//     dv/dt = (u · speed · load − v) / tau        load = 1 − F/limit while closing, 1 while opening
//     dx/dt = v
//     F = stiffness · (x − distance)              where the fingers touch, else 0
class Gripper {
  public:
    struct Parameters {
        double time_constant_ms = 60;
        double speed_mm_per_s = 60;
        double force_limit_n = 25;
        double dead_band = 0.02;
        double stiffness_n_per_mm = 0.6;
        double distance_mm = 20;
    };

    // Throws ParameterError: time constant, speed, force limit and stiffness > 0, distance >= 0, dead_band in
    // [0, 1).
    explicit Gripper(const Parameters& parameters);

    // Moves on for dt under the held command u, -1 (open) to 1 (close), with the load at the beginning of the
    // step. A command that is NaN counts as 0.
    void advance(double command, Duration dt) noexcept;

    struct State {
        double position_mm = 0;  // 0: fully open
        double speed_mm_per_s = 0;
    };
    const State& state() const noexcept { return state_; }
    // Goes on from there; a position that is not finite counts as fully open.
    void resume(const State& state) noexcept;

    double force_n() const noexcept;
    double position_mm() const noexcept { return state_.position_mm; }

  private:
    Parameters parameters_;
    State state_;
};

}  // namespace afferent
