// The brake at a contact: the one command that the user's EMG did not ask for.
#pragma once

#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// A hand that touches an object while it closes keeps the motor's speed for some time after the command has
// ended, and that momentum breaks more than the command does. At a contact the reflex commands the motor
// backwards until the hand nearly stands, and then the command is the user's again.
//
// Nothing measures the speed. It is that of a model of the motor, in units of the speed at full command,
// under the commands that have been given:
//
//     dv/dt = (v∞ − v)/tau       v∞ = max(0, u − F/force_limit)   for u > dead_band
//                                v∞ = u                           for u < −dead_band
//                                v∞ = 0                           between
//
// What it may do is bounded (docs/safe_state.md draws the states):
//   - It brakes once for each contact. A contact begins where the estimate reaches contact_n, and has ended
//     once the estimate has been below release_n for `release`.
//   - It brakes only while the hand closes, and ends where a twentieth of the speed at the contact is left. A
//     motor of which all constants are off by 30 % then opens by less than a millimetre.
//   - In one contact the command backwards, times its duration, is at most `impulse`.
//   - It never closes the hand, and never takes from a user who opens it.
//   - Unless the grip is operating it does nothing, and a contact that begins then is spent.
//
// A force that is NaN begins no contact and ends none.
class ContactReflex {
  public:
    struct Parameters {
        double command = 1;  // backwards, in (0, 1]
        Duration impulse = 40ms;
        double contact_n = 0.3;
        double release_n = 0.1;
        Duration release = 200ms;
        // The motor's constants.
        Duration time_constant{};
        double force_limit_n{};
        double dead_band{};
        bool operator==(const Parameters&) const = default;
    };
    enum class State { armed, braking, spent };

    // Throws ParameterError unless command is in (0, 1], impulse and release are >= 0, contact_n > release_n
    // >= 0, time_constant and force_limit_n are > 0 and dead_band is in [0, 1).
    explicit ContactReflex(const Parameters& parameters);

    // The command from now until the next call, which is the one given or one below it. Times do not
    // decrease.
    double operator()(TimePoint now, double force_n, GripState grip, double command) noexcept;

    // As at the first call.
    void restart() noexcept;

    State state() const noexcept { return state_; }
    // The modelled motor's speed, in units of the speed at full command.
    double speed() const noexcept { return speed_; }

  private:
    double target(double command) const noexcept;
    void move(TimePoint now) noexcept;
    void follow_contact(TimePoint now, GripState grip) noexcept;
    double brake(double command) noexcept;

    Parameters parameters_;
    State state_ = State::armed;
    TimePoint last_ = scene_start;
    Duration step_{};          // between the last two calls
    TimePoint touched_{};      // when the force was last at release_n or above
    Duration impulse_left_{};  // of this contact
    double slow_enough_ = 0;   // the speed at which the brake ends
    double force_n_ = 0;
    double command_ = 0;
    double speed_ = 0;
};

}  // namespace afferent
