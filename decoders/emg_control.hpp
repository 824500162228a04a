// Combines the estimate of the grip force and the user's EMG into the motor command. Included by programs
// that control a motor without a scene.
#pragma once

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/effort.hpp"
#include "afferent/runtime/grip_state.hpp"

namespace afferent {

struct GripCommand {
    double gain = 0;     // applied to the closing effort, 0 to 1
    double command = 0;  // of the motor, -1 (open) to 1 (close)

    friend bool operator==(const GripCommand&, const GripCommand&) = default;
};

// The grip force attenuates the closing EMG, and never the opening EMG:
//
//     operating        command = gain · closing − opening
//     frozen, or hold  command = −opening: the user may open
//     open             command = −0.5, whatever the user does
//
// For all arguments, NaN and infinity included:
//   - gain and command are within their ranges;
//   - unless the state is `operating` the gain is 0 and the command does not close the hand (<= 0);
//   - a force or an effort that is NaN never closes it.
class EmgControl {
  public:
    struct Parameters {
        EmgGain::Parameters gain;
        SafeState safe_state = SafeState::hold;
    };

    // Throws ParameterError if the parameters of the gain are invalid (emg_gain.hpp).
    explicit EmgControl(const Parameters& parameters)
        : gain_(parameters.gain), safe_state_(parameters.safe_state) {}

    GripCommand operator()(const Estimate& estimate, GripState state, const Effort& effort) const noexcept;

  private:
    EmgGain gain_;
    SafeState safe_state_;
};

}  // namespace afferent
