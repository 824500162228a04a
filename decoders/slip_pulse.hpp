// The closing pulse at a slip: a command that closes the hand further than the user's EMG asks for.
#pragma once

#include <cstdint>

#include "afferent/decoders/estimate.hpp"
#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// The motor cannot be driven backwards, so that in a hand that nothing opens the force falls only where the
// object gives way, as it does while it slips through the fingers. At such a fall the pulse closes the hand
// for a moment, as in the experiment of Osborn et al. (IEEE Trans. Haptics 2016).
//
// The fall counts from a peak that forgets:
//
//     peak := F where F >= peak;  d peak/dt = (F − peak)/within  below it
//     slip: peak − F >= max(fall_n, fall_sigmas · sigma)
//
// What it may do is bounded (docs/safe_state.md draws the states):
//   - The pulse is held back by the gain as the user's EMG is: it is command · gain, and 0 from the limit on.
//   - Where a command opens the hand, the user's or the brake's, there is no slip until `within` after it. A
//     dead band above 0.1 is taken for 0.1: it may be wrong, and the user may be opening.
//   - In the first `settle` of a contact there is none, because the estimate still settles then.
//   - It lasts for `pulse`, and the next one comes `within` after it at the earliest.
//   - In one contact there are at most `most`. A contact has ended once F has been below fall_n for `within`.
//   - Only an F that has been heard counts: a packet that is missing or lost leaves a silence like a fall.
//   - Unless the grip is operating it does nothing, nor while a doubt of the estimate is more than `slow`.
//
// A force or sigma that is NaN is no slip.
class SlipPulse {
  public:
    struct Parameters {
        double command = 1;  // in (0, 1]
        Duration pulse = 60ms;
        double fall_n = 0.1;
        double fall_sigmas = 1;
        Duration within = 100ms;
        Duration settle = 400ms;
        std::uint32_t most = 5;
        double dead_band = 0;  // the motor's: weaker commands do not open the hand
        bool operator==(const Parameters&) const = default;
    };
    enum class State { watching, pulsing, resting };

    // Throws ParameterError unless command is in (0, 1], pulse, fall_n and within are > 0, settle and
    // fall_sigmas >= 0, most >= 1 and dead_band is in [0, 1).
    explicit SlipPulse(const Parameters& parameters);

    // The command from now until the next call, which is the one given or one above it. Times do not
    // decrease. `heard`: no packet is missing for what the estimate tells of, and none was lost
    // just before.
    double operator()(TimePoint now, const Estimate& estimate, bool heard, GripState grip, double gain,
                      double command) noexcept;

    // As at the first call.
    void restart() noexcept { *this = SlipPulse(parameters_); }

    State state() const noexcept { return state_; }
    // That were begun in this contact.
    std::uint32_t pulses() const noexcept { return pulses_; }

  private:
    void follow(TimePoint now, double force_n) noexcept;
    void follow_contact(TimePoint now) noexcept;
    void rest(TimePoint now) noexcept;
    bool slips(TimePoint now, const Estimate& estimate) const noexcept;

    Parameters parameters_;
    State state_ = State::watching;
    TimePoint last_ = scene_start;
    TimePoint until_{};    // the pulse, or the rest after it
    TimePoint touched_{};  // when the force was last at fall_n or above
    TimePoint contact_{};  // when the contact began
    bool in_contact_ = false;
    double peak_n_ = 0;
    double force_n_ = 0;
    std::uint32_t pulses_ = 0;
};

}  // namespace afferent
