// The user of a prosthesis in a trial: reaches, sees the contact, grips, lifts and relaxes.
#pragma once

#include <cstdint>
#include <optional>

namespace afferent {

// What a user controls is the effort of the closing muscle, and not the force: the user feels nothing, and
// sees a contact or a slip only after a reaction time. From practice the user knows which effort ends at
// which force (force = effort · force_limit, hand/prosthesis_motor.hpp), and aims by that; what the
// electrodes add at rest and by their noise is not known to the user.
//
//     begin            reaches with an effort of its own
//     sees contact     reaction time after it: the effort that aims at the force
//     grip later       lifts, and carries the weight after `lift`
//     sees a slip      reaction time after it: slip_effort times that effort, until the end
//     settle later     without a slip in sight: relaxes, and the hand holds by itself
//     hold later       the presentation is over
//
// Each effort reaches the electrode after the electromechanical delay, and approaches its goal with the time
// constant of the contraction. The user aims at aim_n · exp(user_spread · z_user + aim_spread · z), reaches
// and reacts likewise.
class TrialUser {
  public:
    struct Parameters {
        std::uint32_t users = 10;  // assumed, as are all that name no source
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
        double patience_s = 5;  // without a contact
        bool operator==(const Parameters&) const = default;
    };
    // What a user intends in one presentation.
    struct Intent {
        double aimed_force_n;
        double reach_effort;
        double grip_effort;
        double reaction_s;
    };
    // When, in seconds since the beginning; what has not happened is absent.
    struct Seen {
        std::optional<double> contact_s;
        std::optional<double> slip_s;
    };

    // Throws ParameterError: users > 0, times and spreads >= 0, contraction_ms, patience_s and aim_n > 0,
    // reach_effort above 0 and at most 1, slip_effort >= 1.
    TrialUser(const Parameters& parameters, double force_limit_n, std::uint64_t seed);

    // An object that has to be gripped harder than a delicate one: by the factor.
    Intent intent(std::uint32_t number, double aim_factor = 1) const noexcept;

    // The effort that the user's muscle is heading for, 0 to 1. What happened acts when it has been seen.
    double aimed_effort(const Intent& intent, double time_s, const Seen& seen) const noexcept;
    // How much of the weight the hand carries, 0 to 1.
    double lifted(const Intent& intent, double time_s, const Seen& seen) const noexcept;
    // When the presentation is over.
    double end_s(const Intent& intent, const Seen& seen) const noexcept;

    const Parameters& parameters() const noexcept { return parameters_; }

  private:
    double lift_at_s(const Intent& intent, double contact_s) const noexcept;

    Parameters parameters_;
    double force_limit_n_;
    std::uint64_t seed_;
};

}  // namespace afferent
