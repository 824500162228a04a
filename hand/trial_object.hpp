// The objects of a trial, which break when squeezed and slip when held too loosely. Included by whoever
// builds a scene with a trial.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/runtime/time.hpp"

namespace afferent {

// An object between the fingers. It breaks as soon as the force exceeds its breaking force. While lifted, it
// slips when friction on both sides does not carry the load, and comes to rest when it does (Coulomb):
//
//     F = stiffness · max(0, x − distance − taper · s)     s: how far it has slipped
//     at rest     while load <= 2 · friction · F
//     slipping    d²s/dt² = g (load − 2 · friction · F)/weight,  ds/dt >= 0
//
// Until the hand carries the full weight the object still stands on the table, and slips no faster than the
// hand rises: ds/dt <= lift speed.
//
// The stiffness is that of object and fingertips in series; the taper narrows the object downwards. Static
// and kinetic friction are assumed equal, as on rubber fingertips.
class TrialObject {
  public:
    struct Parameters {
        double stiffness_n_per_mm = 0.6;
        double distance_mm = 30;                      // that the fingers move before the contact
        std::optional<double> breaking_force_n = {};  // none: it does not break
        double weight_n = 0.15;
        double friction = 0.6;
        double taper = 0;
        double lift_mm_per_s = 60;
    };
    struct State {
        bool broken = false;
        double slipped_mm = 0;
        double slip_mm_per_s = 0;
        bool carried = false;  // it has left the table
        bool slips() const noexcept { return slip_mm_per_s > 0; }
    };

    explicit TrialObject(const Parameters& parameters) noexcept : parameters_(parameters) {}

    // The grip force with the fingers at that position.
    double force_n(double position_mm) const noexcept;
    // Advances by dt with the fingers at that position and the hand carrying the fraction `lifted` of the
    // weight, 0 to 1.
    void advance(double position_mm, double lifted, Duration dt) noexcept;

    const Parameters& parameters() const noexcept { return parameters_; }
    const State& state() const noexcept { return state_; }

  private:
    Parameters parameters_;
    State state_;
};

// The objects of a trial. Medians; a spread is the standard deviation of the natural logarithm.
struct TrialObjects {
    struct Delicate {
        double stiffness_n_per_mm = 2.5;
        double stiffness_spread = 0.6;
        double breaking_force_n = 12;
        double breaking_spread = 0.3;
        double least_breaking_force_n = 8;
        double weight_n = 0.15;
        double friction = 0.6;
        double distance_mm = 30;
        double distance_spread = 0.15;
        bool operator==(const Delicate&) const = default;
    };
    struct Slippery {
        double part = 0.2;  // fraction of all presentations
        double stiffness_n_per_mm = 1.5;
        double stiffness_spread = 0.4;
        double weight_n = 3;
        double weight_spread = 0.25;
        double friction = 0.4;
        double taper = 0.1;
        double distance_mm = 20;
        double distance_spread = 0.15;
        double aim_factor = 2;  // the user grips it harder than a delicate object by this factor
        bool operator==(const Slippery&) const = default;
    };

    Delicate delicate = {};
    Slippery slippery = {};
    bool operator==(const TrialObjects&) const = default;

    // Throws ParameterError unless spreads, taper and least force are >= 0, part is in [0, 1], the median
    // breaking force is above the least, and all others are > 0.
    void check() const;
    // Whether the slippery object is presented in the presentation with that number.
    bool is_slippery(std::uint64_t seed, std::uint32_t number) const noexcept;
    // The object of the presentation with that number. Breaking forces are log-normal, truncated at the
    // least.
    TrialObject::Parameters object(std::uint64_t seed, std::uint32_t number) const noexcept;
};

}  // namespace afferent
