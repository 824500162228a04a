// The posterior of a grip force, its rate of change, and each element's departure from its share of it: a
// bank of Gaussians, and rest.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/force_motion.hpp"

namespace afferent {

// How far readings depart from the elements' shares of the grip force F: element i reads (1 + e_i) F, in
// newtons of grip, where F is what all read together: Σ share_i e_i = 0. A departure by gain is constant; one
// by share wanders.
struct ElementSpread {
    std::vector<double> share{};  // of the elements, > 0 and with a sum of 1; none: they do not depart
    double gain_variance = 0;     // of e_i, due to the element's gain
    double share_variance = 0;    // of e_i, due to its share
    double share_time_s = 1;      // correlation time of a share
};

// A force F and its rate V in one of several motions, or at rest (F = 0). In a hold, a movement and a contact
// the rate wanders; in a release, that of a hand that opens, the force returns to 0 (force_motion.hpp).
//
// The motion may change at any time, at constant rates; one that falls at the speed V, and not slowly,
// becomes a release at `releases` times |V|/F. A force that has come down to zero is at rest, unless it was
// in a hold. The motions are weighed by how well they predict what is measured, so that a contact is followed
// at once and a hold is quiet (an interacting-multiple-model filter: Blom and Bar-Shalom 1988).
//
// The e_i are part of each Gaussian. A measurement is of (1 + e_i)(F − lag V), linearised at the mean.
//
// Forces are in the caller's unit. A step of time or a measurement costs (2 + elements)² for each motion.
// Allocates nothing after construction.
class ForceBelief {
  public:
    using enum ForceBeliefParameters::Motions;
    using Parameters = ForceBeliefParameters;
    // What a motion that is left becomes: of a hold, half of the time a movement, and so on.
    static constexpr double becomes[motions][motions] = {{0, 0.3, 0.3, 0, 0.4, 0}, {0.2, 0, 0.1, 0, 0.3, 0.4},
                                                         {0.1, 0.8, 0, 0, 0, 0.1}, {0.3, 0.4, 0.2, 0, 0.1, 0},
                                                         {0.5, 0.3, 0.2, 0, 0, 0}, {0.1, 0.8, 0, 0, 0.1, 0}};
    // At rest a force is within this of 0, and a force that has just left rest within that.
    static constexpr double rest_variance_n2 = 0.0025;
    static constexpr double contact_variance_n2 = 0.05;
    static constexpr std::size_t most_elements = 32;
    // Correlation time of a gain, which drifts slowly.
    static constexpr double gain_time_s = 10;

    // Knows only that F lies between 0 and a largest force. `spread` has at most most_elements.
    ForceBelief(const Parameters& parameters, const ElementSpread& spread, double largest_n);
    ForceBelief(const Parameters& parameters, double largest_n) : ForceBelief(parameters, {}, largest_n) {}

    // A measured quantity: the force as an element reads it, lag_s ago; without an element, F − lag V.
    struct View {
        static constexpr std::uint32_t of_grip = static_cast<std::uint32_t>(-1);
        double lag_s = 0;
        std::uint32_t element = of_grip;
    };

    // Lets dt_s pass. The shares wander `wander` times as strongly as stated.
    void predict(double dt_s, double wander = 1) noexcept;
    // The view measured force_n with that variance. Each of `together` simultaneous measurements has that
    // part of a say in which motion it is.
    void measure(double force_n, const View& view, double variance_n2, double together = 1) noexcept;
    // The square of how many standard deviations such a measurement is away from what the motion expects that
    // expects it best, of those that are likely at all.
    double misfit(double force_n, const View& view, double variance_n2) const noexcept;
    // The view is at most bound_n, and F is not negative.
    void bound(double bound_n, const View& view) noexcept;
    // The view is at least bound_n.
    void bound_below(double bound_n, const View& view) noexcept;
    // |V| measured speed_n_per_s, lag_s ago, with that variance.
    void measure_speed(double speed_n_per_s, double lag_s, double variance_n2_per_s2) noexcept;
    // |V| was at most bound_n_per_s, lag_s ago.
    void bound_speed(double bound_n_per_s, double lag_s) noexcept;
    // V is at least bound_n_per_s.
    void bound_speed_below(double bound_n_per_s) noexcept;
    // Adds a variance to e_i.
    void widen(std::uint32_t element, double variance) noexcept;
    // Widens all e_i, as if the shares had wandered so much more strongly than stated.
    void loosen(double wander) noexcept;
    // Leaves an element out of the sum that is F, or takes it in again. Its e_i is then known to the spread
    // only.
    void exclude(std::uint32_t element) noexcept;
    void include(std::uint32_t element) noexcept;

    // Resets all e_i to their spread.
    void forget_departures() noexcept;

    struct Moments {
        double mean_n, variance_n2;
    };
    Moments of_past(const View& view) const noexcept;
    // The moments of F after dt_s in which no motion changes.
    Moments after(double dt_s) const noexcept;
    double mean_n() const noexcept { return of_past({}).mean_n; }
    double variance_n2() const noexcept { return of_past({}).variance_n2; }
    // The moments of |V|, in N/s.
    Moments of_speed() const noexcept;
    // The moments of e_i, which has no unit.
    Moments of_element(std::uint32_t element) const noexcept;
    // Gives rest this weight, 0 to 1, and the motions the remainder. After construction rest has 0.97.
    void presume_rest(double weight) noexcept;
    // The weight of rest.
    double at_rest() const noexcept { return rest_; }

    // The weight of the release among the motions.
    double releasing() const noexcept { return bank_[release].weight / (1 - rest_); }

    std::size_t heap_bytes() const noexcept;

    friend bool operator==(const ForceBelief& one, const ForceBelief& other) noexcept {
        return one.bank_ == other.bank_ && one.rest_ == other.rest_ && one.share_ == other.share_;
    }

  private:
    // A joint distribution of F, V and the e_i.
    struct Gaussian {
        std::vector<double> mean, covariance;
        double weight = 0;
        friend bool operator==(const Gaussian&, const Gaussian&) = default;
    };
    class Reading;
    class Projection;
    // Multiplies the weights by exp(exponent)·factor; the last is that of rest.
    struct Likelihood {
        double exponent = 0, factor = 1;
    };
    void normalise() noexcept;
    void weigh(const std::array<Likelihood, motions + 1>& likelihood) noexcept;
    void mix(const double (&share)[motions + 1][motions]) noexcept;
    void flow(Gaussian& x, const ForceFlow& by) const noexcept;
    void wander(Gaussian& x, double dt_s, double wander) const noexcept;
    void project_spread() noexcept;
    // The prior covariance of e_i and e_j.
    double spread(std::size_t i, std::size_t j, double wander) const noexcept;
    void share_among(std::uint32_t element, double share) noexcept;
    void keep_positive() noexcept;

    Parameters parameters_;
    ElementSpread spread_;
    std::vector<double> share_;        // of those that are not excluded
    std::size_t size_;                 // of a Gaussian
    std::vector<double> projected_{};  // the prior covariance of the e_i, in units of the variance of one
    std::array<Gaussian, motions> bank_;
    std::array<Gaussian, motions> mixed_;  // scratch
    Gaussian left_rest_;                   // scratch
    double rest_;
};

}  // namespace afferent
