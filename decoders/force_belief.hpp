// What is believed of a force and of its rate of change: a bank of Gaussians, and rest.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "afferent/decoders/force_motion.hpp"

namespace afferent {

// A force F and its rate V in one of four motions, or at rest (F = 0). In a hold, a movement and a contact
// the rate wanders; in a release, that of a hand that opens, the force returns to 0 (force_motion.hpp).
//
// The motion may change at any time, at constant rates; one that falls at the speed V becomes a release at
// `releases` times |V|/F. A force that has come down to zero is at rest, unless it was in a hold. The motions
// are weighed by how well they predict what is measured, so that a contact is followed at once and a hold is
// quiet (an interacting-multiple-model filter: Blom and Bar-Shalom 1988).
class ForceBelief {
  public:
    enum { hold, movement, contact, release, motions };
    struct Parameters {
        std::array<ForceMotion, motions> motion = {{{0.042, 0.12, 4e-5, 1.7},
                                                    {62, 0.35, 1e-6, 7e-5},
                                                    {70, 0.021, 7e-6, 47},
                                                    {21, 0.043, 4e-6, 1.3}}};
        double releases = 3;
        double leaves_rest_per_s = 0.15;

        ForceFlow flow(std::size_t of, double dt_s) const noexcept {
            return of == release ? returning(motion[of], dt_s) : wandering(motion[of], dt_s);
        }
        // At which any motion but a release becomes one.
        double releases_per_s(double force_n, double speed_n_per_s) const noexcept {
            return releases * std::max(0.0, -speed_n_per_s) / std::max(force_n, 0.3);
        }
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };
    // What a motion that is left becomes: of a hold, half of the time a movement, and so on.
    static constexpr double becomes[motions][motions] = {
        {0, 0.5, 0.5, 0}, {0.8, 0, 0.2, 0}, {0.1, 0.9, 0, 0}, {0.3, 0.5, 0.2, 0}};
    // At rest a force is within this of 0, and a force that has just left rest within that.
    static constexpr double rest_variance_n2 = 0.0025;
    static constexpr double contact_variance_n2 = 0.05;

    // Nothing is known but that F is 0 to some largest force.
    ForceBelief(const Parameters& parameters, double largest_n) noexcept;

    // `dt_s` passes.
    void predict(double dt_s) noexcept;
    // F − lag V was force_n, with that variance.
    void measure(double force_n, double lag_s, double variance_n2) noexcept;
    // The square of how many standard deviations such a measurement is away from what the motion expects that
    // expects it best, of those that are likely at all.
    double misfit(double force_n, double lag_s, double variance_n2) const noexcept;
    // F − lag V was at most bound_n, and F is not negative.
    void bound(double bound_n, double lag_s) noexcept;
    // |V| was speed_n_per_s, with that variance, so long ago.
    void measure_speed(double speed_n_per_s, double lag_s, double variance_n2_per_s2) noexcept;
    // |V| was less.
    void bound_speed(double bound_n_per_s, double lag_s) noexcept;

    double mean_n() const noexcept { return of_past(0).mean_n; }
    double variance_n2() const noexcept { return of_past(0).variance_n2; }
    struct Moments {
        double mean_n, variance_n2;
    };
    // Of F − lag V.
    Moments of_past(double lag_s) const noexcept;
    // Of |V|, in N/s.
    Moments of_speed() const noexcept;
    // The weight of rest.
    double at_rest() const noexcept { return rest_; }

    struct Gaussian {
        double force_n = 0, speed_n_per_s = 0;
        double ff = 0, fv = 0, vv = 0;  // covariance
        double weight = 0;
        friend bool operator==(const Gaussian&, const Gaussian&) = default;
    };
    friend bool operator==(const ForceBelief& one, const ForceBelief& other) noexcept {
        return one.bank_ == other.bank_ && one.rest_ == other.rest_;
    }

  private:
    void normalise() noexcept;
    // Multiplies the weights by exp(exponent)·factor; the last is that of rest.
    struct Likelihood {
        double exponent = 0, factor = 1;
    };
    void weigh(const std::array<Likelihood, motions + 1>& likelihood) noexcept;

    Parameters parameters_;
    std::array<Gaussian, motions> bank_;
    double rest_;
};

}  // namespace afferent
