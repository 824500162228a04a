// Which branch of their hysteresis the sensors are on, as the force loads and unloads them.
#pragma once

#include <algorithm>
#include <cmath>

namespace afferent {

// Takes hysteresis for the play that hand/sensor.hpp simulates: while the force rises the sensors read low by
// a part of it, while it falls they read high. The branch reverses once measurements in a row are surely back
// from the force's extreme by more than half of the hysteresis.
class HysteresisBranch {
  public:
    explicit HysteresisBranch(double hysteresis) noexcept : hysteresis_(hysteresis) {}

    // Takes a measurement of the sensed force into account.
    void follow(double mean_n, double sigma_n) noexcept {
        if (beyond_reversal_n(mean_n, sigma_n) <= 0) {
            reversing_ = 0;
            const double surely_n = mean_n - direction_ * sure * sigma_n;
            if (direction_ * (surely_n - extreme_n_) >= 0) extreme_n_ = surely_n;
            return;
        }
        if (reversing_ == 0 || direction_ * (mean_n - reversed_n_) < 0) reversed_n_ = mean_n;
        if (++reversing_ < measurements_to_reverse) return;
        direction_ = -direction_;
        extreme_n_ = reversed_n_;
        reversing_ = 0;
    }

    // +1: loading, −1: unloading. Silence alone may say that the force falls, before any measurement does.
    double direction(double mean_n, double sigma_n) const noexcept {
        return direction_ > 0 && beyond_reversal_n(mean_n, sigma_n) > 0 ? -1 : direction_;
    }
    // The grip force behind a sensed one.
    double grip_n(double sensed_n, double sigma_n) const noexcept {
        return sensed_n / (1 - hysteresis_ * direction(sensed_n, sigma_n));
    }
    // Within the play, which is twice as wide, the sensors read the same whatever the force is.
    double sigma_n(double sensed_n) const noexcept { return 0.75 * hysteresis_ * sensed_n; }

    friend bool operator==(const HysteresisBranch&, const HysteresisBranch&) = default;

  private:
    // Standard deviations that make a reversal sure; a smaller one may be noise.
    static constexpr double sure = 2;
    // The part of the hysteresis that the force has to come back: all of it has passed the play by then.
    static constexpr double play_to_pass = 0.5;
    // One measurement that is off by more than it should be does not reverse the branch.
    static constexpr int measurements_to_reverse = 5;

    double beyond_reversal_n(double mean_n, double sigma_n) const noexcept {
        return direction_ * (extreme_n_ - mean_n) - sure * sigma_n -
               play_to_pass * hysteresis_ * std::abs(extreme_n_);
    }

    double hysteresis_;
    double direction_ = 1;
    double extreme_n_ = 0;
    int reversing_ = 0;  // measurements in a row
    double reversed_n_ = 0;
};

}  // namespace afferent
