// The output that turns the user's closing EMG down as the grip force rises.
#pragma once

#include "afferent/decoders/emg_gain.hpp"
#include "afferent/decoders/output.hpp"

namespace afferent {

//     operating        command = gain · closing − opening
//     frozen, or hold  command = −opening: the user may open
//     open             command = −0.5, whatever the user does
class EmgGainOutput {
  public:
    struct Parameters {
        EmgGain::Parameters gain;
        SafeState safe_state = SafeState::hold;
    };

    // Throws ParameterError, as EmgGain does.
    explicit EmgGainOutput(const Parameters& parameters)
        : gain_(parameters.gain), safe_state_(parameters.safe_state) {}

    GripCommand operator()(TimePoint now, const Estimate& estimate, GripState state,
                           const Effort& effort) const noexcept;

  private:
    EmgGain gain_;
    SafeState safe_state_;
};

static_assert(Output<EmgGainOutput>);

}  // namespace afferent
