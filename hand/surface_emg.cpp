#include "afferent/hand/surface_emg.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/hand/random.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

SurfaceEmg::SurfaceEmg(const Parameters& parameters, double rate_hz, std::uint64_t seed, Stream electrode)
    : parameters_(parameters), seed_(seed), electrode_(electrode) {
    require(parameters.centre_hz > 0 && 2 * parameters.centre_hz < rate_hz, "centre_hz",
            "> 0 and below half of emg_rate_hz", parameters.centre_hz);
    require(parameters.bandwidth_hz > 0, "bandwidth_hz", "> 0", parameters.bandwidth_hz);
    require(parameters.rest_effort >= 0 && parameters.rest_effort <= 1, "rest_effort", "0 to 1",
            parameters.rest_effort);
    const double radius = std::exp(-std::numbers::pi * parameters.bandwidth_hz / rate_hz);
    a1_ = 2 * radius * std::cos(2 * std::numbers::pi * parameters.centre_hz / rate_hz);
    a2_ = -radius * radius;
    // The process then has unit variance.
    innovation_ = std::sqrt((1 + a2_) * ((1 - a2_) * (1 - a2_) - a1_ * a1_) / (1 - a2_));
    begin(0);
}

void SurfaceEmg::begin(std::uint32_t recording) noexcept {
    recording_ = recording;
    sample_ = 0;
    // Two neighbouring values with the stationary correlation a1/(1 − a2).
    const double correlation = a1_ / (1 - a2_);
    before_last_ = next();
    last_ = correlation * before_last_ + std::sqrt(1 - correlation * correlation) * next();
}

double SurfaceEmg::next() noexcept { return gaussian(seed_, electrode_, recording_, sample_++); }

double SurfaceEmg::counts(double effort) noexcept {
    const double value = a1_ * last_ + a2_ * before_last_ + innovation_ * next();
    before_last_ = last_;
    last_ = value;
    // The mean absolute value of a normal number is sqrt(2/pi) of its standard deviation.
    const double sigma = User::full_scale_counts * std::sqrt(std::numbers::pi / 2) *
                         std::hypot(effort, parameters_.rest_effort);
    constexpr double highest_count = 4095;
    return std::clamp(std::round(User::rest_counts + sigma * value), 0.0, highest_count);
}

}  // namespace afferent
