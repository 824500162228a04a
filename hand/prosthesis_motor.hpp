// The motor of a prosthetic hand under a proportional command. Included by whoever builds a scene with a
// trial, or simulates a hand.
#pragma once

#include "afferent/runtime/time.hpp"

namespace afferent {

// A DC motor behind a self-locking gear that moves the fingers against the grip force F:
//
//     dv/dt = (v∞ − v)/tau                             dx/dt = v
//     v∞ = max_speed · max(0, u − F/force_limit)       for u > dead_band
//     v∞ = max_speed · u                               for u < −dead_band
//     v∞ = 0                                           between
//
// max_speed = aperture/closing_s. The first case is the speed–force line of a DC motor at the voltage u.
//
// A held command u therefore ends at the force u · force_limit, and the force remains when the command ends.
// The defaults: speed and force in proportion to the EMG, full closing in half a second to a second, and 26.5
// N in the lateral grip, as of a bebionic hand (RSLSteeper, technical manual; 140 N in the power grip).
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

    // Throws ParameterError unless aperture, closing time, force limit and time constant are > 0 and
    // dead_band is in [0, 1).
    explicit ProsthesisMotor(const Parameters& parameters);

    // Advances by dt under a command from -1 (open) to 1 (close) and a grip force in N. A non-finite command
    // counts as 0.
    void advance(double command, double force_n, Duration dt) noexcept;

    const State& state() const noexcept { return state_; }
    void reset() noexcept { state_ = {}; }

  private:
    Parameters parameters_;
    State state_;
};

}  // namespace afferent
