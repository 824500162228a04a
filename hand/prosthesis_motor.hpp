// The motor of a prosthetic hand under a proportional command.
#pragma once

#include "afferent/runtime/time.hpp"

namespace afferent {

// A DC motor behind a gear that cannot be driven backwards, with the fingers' travel and the grip force F as
// its load:
//
//     dv/dt = (v∞ − v)/tau                             dx/dt = v
//     v∞ = max_speed · max(0, u − F/force_limit)       for u > dead_band
//     v∞ = max_speed · u                               for u < −dead_band
//     v∞ = 0                                           between
//
// max_speed = aperture/closing_s. The first of the three is the speed–force line of a DC motor at the voltage
// u.
//
// So a held command u ends at the force u · force_limit, and the force stays when the command goes. Speed and
// force in proportion to the EMG, full closing in half a second to a second and 26.5 N in the lateral grip
// are those of a bebionic hand (RSLSteeper, technical manual; 140 N in the power grip).
class ProsthesisMotor {
  public:
    struct Parameters {
        double aperture_mm = 90;  // from open to closed
        double closing_s = 0.8;   // at full command, without load
        double force_limit_n = 26.5;
        double time_constant_ms = 40;
        double dead_band = 0.08;
        bool operator==(const Parameters&) const = default;
    };
    struct State {
        double position_mm = 0;  // 0: open
        double speed_mm_per_s = 0;
    };

    // Throws ParameterError: aperture, closing time, force limit and time constant > 0, dead_band in [0, 1).
    explicit ProsthesisMotor(const Parameters& parameters);

    // Moves on for dt under a command of -1 (open) to 1 (close) and a grip force. A command that is not
    // finite counts as 0.
    void advance(double command, double force_n, Duration dt) noexcept;

    const State& state() const noexcept { return state_; }
    void reset() noexcept { state_ = {}; }

  private:
    Parameters parameters_;
    State state_;
};

}  // namespace afferent
