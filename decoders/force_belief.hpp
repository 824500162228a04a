// What is believed of a force and of its rate of change: a bank of Gaussians, and rest.
#pragma once

#include <array>

namespace afferent {

// A force F and its rate V under one of three motions, or at rest (F = 0). In each motion
//
//     dF = V dt + q dW,      dV = −V/τ dt + σ sqrt(2/τ) dB
//
// so that V has the standard deviation σ. The motion may change at any time, at constant rates; a force that
// falls at the speed V may also come to rest, at `comes_to_rest` times |V|/F, as a hand that opens lets go.
// The motions are weighed by how well they predict what is measured, so that a contact is followed at once
// and a hold is quiet (an interacting-multiple-model filter: Blom and Bar-Shalom 1988).
class ForceBelief {
  public:
    struct Motion {
        double speed_n_per_s;   // σ
        double time_s;          // τ
        double drift_n2_per_s;  // q²
        double leaves_per_s;
        friend bool operator==(const Motion&, const Motion&) = default;
    };
    // hold, movement, contact
    static constexpr int motions = 3;
    struct Parameters {
        std::array<Motion, motions> motion = {{{0.5, 0.3, 5e-4, 1}, {35, 1, 1e-3, 5}, {100, 0.06, 1e-2, 20}}};
        double comes_to_rest = 1;
        double leaves_rest_per_s = 1;
        friend bool operator==(const Parameters&, const Parameters&) = default;
    };

    // Nothing is known but that F is 0 to some largest force.
    ForceBelief(const Parameters& parameters, double largest_n) noexcept;

    // `dt_s` passes.
    void predict(double dt_s) noexcept;
    // F − lag V was force_n, with that variance.
    void measure(double force_n, double lag_s, double variance_n2) noexcept;
    // F − lag V was between 0 and bound_n, and F is not negative.
    void bound(double bound_n, double lag_s) noexcept;

    double mean_n() const noexcept;
    double variance_n2() const noexcept;
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
    // Multiplies the weights by likelihoods; the last is that of rest.
    void weigh(const std::array<double, motions + 1>& log_likelihood) noexcept;

    Parameters parameters_;
    std::array<Gaussian, motions> bank_;
    double rest_;
};

}  // namespace afferent
