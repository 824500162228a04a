// The user of a prosthesis in a trial, who reaches, sees the contact, grips, lifts and relaxes. Included by
// whoever builds a scene with a trial.
#pragma once

#include <cstdint>
#include <optional>

namespace afferent {

// A user controls the effort of the closing muscle, not the force: the user feels nothing, and sees a contact
// or a slip only after a reaction time. From practice the user knows which effort leads to which force (force
// = effort · force_limit, hand/prosthesis_motor.hpp), but not what the electrodes add at rest and by noise.
//
//     begin            reaches with an effort of its own
//     sees contact     reaction time after it: the effort that aims at the force
//     grip later       lifts, and carries the weight after `lift`
//     sees a slip      reaction time after it: slip_effort times that effort, until the end
//     settle later     without a slip in sight: relaxes, and the hand holds by itself
//     hold later       the presentation is over
//
// Each effort reaches the electrode after the electromechanical delay, and approaches its goal with the time
// constant of the contraction. The user aims at aim_n · exp(user_spread · z_user + aim_spread · z) with
// standard normal z; efforts and reaction times are spread in the same way.
class TrialUser {
  public:
    struct Parameters {
        std::uint32_t users = 10;  // assumed, as are all defaults without a source
        double begin_s = 0.2;
        double reach_effort = 0.31;
        double reach_spread = 0.25;
        double aim_n = 7.3;
        double aim_spread = 0.25;
        double user_spread = 0.15;  // of the aim, between users
        double reaction_ms = 220;   // to see: median 213 (Woods et al., Front. Hum. Neurosci. 2015)
        double reaction_spread = 0.15;
        double delay_ms = 50;  // from EMG to force: 30 to 100 (Cavanagh and Komi, EJAP 1979)
        double contraction_ms = 60;
        double grip_s = 0.6;
        double lift_s = 0.4;  // until the hand carries the weight
        double lift_mm_per_s = 60;
        double settle_s = 0.2;
        double hold_s = 0.5;
        double slip_effort = 1.5;
        double patience_s = 5;  // until the user gives up without a contact
        double press_on = 0;    // how much effort a weak hand adds: · (1 + press_on · weakness)
        bool operator==(const Parameters&) const = default;
    };
    // The user's intentions in one presentation.
    struct Intent {
        double aimed_force_n;
        double reach_effort;
        double grip_effort;
        double reaction_s;
    };
    // When events happened, in seconds since the beginning; absent if they have not happened.
    struct Seen {
        std::optional<double> contact_s;
        std::optional<double> slip_s;
        double weakness = 0;  // 1 − gain, as the user has noticed it
    };

    // Throws ParameterError unless users > 0, times, spreads and press_on are >= 0, contraction_ms,
    // patience_s and aim_n are > 0, reach_effort is above 0 and at most 1, and slip_effort >= 1.
    TrialUser(const Parameters& parameters, double force_limit_n, std::uint64_t seed);

    // The intentions in the presentation with that number. `aim_factor`: how much harder the object has to be
    // gripped than a delicate one.
    Intent intent(std::uint32_t number, double aim_factor = 1) const noexcept;

    // The effort that the muscle approaches, 0 to 1. Events act after the reaction time.
    double aimed_effort(const Intent& intent, double time_s, const Seen& seen) const noexcept;
    // The fraction of the weight that the hand carries, 0 to 1.
    double lifted(const Intent& intent, double time_s, const Seen& seen) const noexcept;
    // The end of the presentation.
    double end_s(const Intent& intent, const Seen& seen) const noexcept;

    const Parameters& parameters() const noexcept { return parameters_; }

  private:
    double lift_at_s(const Intent& intent, double contact_s) const noexcept;

    Parameters parameters_;
    double force_limit_n_;
    std::uint64_t seed_;
};

}  // namespace afferent
