// The EMG of one electrode: noise whose amplitude is the effort of the muscle under it. Included by whoever
// builds a scene with a trial, or simulates EMG.
#pragma once

#include <cstdint>

namespace afferent {

enum class Stream : std::uint32_t;

// A Gaussian process of unit variance with the spectrum of a surface EMG, times an amplitude (Hogan and Mann,
// IEEE Trans. Biomed. Eng. 1980):
//
//     x_k = 2 r cos(θ) x_{k−1} − r² x_{k−2} + w_k          r = exp(−π bandwidth/rate)    θ = 2π centre/rate
//     counts = rest + full scale · sqrt(π/2) · sqrt(effort² + rest_effort²) · x
//
// so that the mean of the rectified signal is sqrt(effort² + rest_effort²) of full scale. The noise is
// multiplicative: the amplitude measured in a window of 60 ms has a coefficient of variation of 0.16 at any
// effort, and 0.09 in one of 200 ms. White noise, as hand/user.hpp has it, would have 0.10 and 0.05.
class SurfaceEmg {
  public:
    struct Parameters {
        double centre_hz = 100;
        double bandwidth_hz = 80;
        double rest_effort = 0.05;
        bool operator==(const Parameters&) const = default;
    };

    // Throws ParameterError unless centre_hz is > 0 and below half the rate, bandwidth_hz > 0, and
    // rest_effort is in [0, 1].
    SurfaceEmg(const Parameters& parameters, double rate_hz, std::uint64_t seed, Stream electrode);

    // Starts the recording with that number, in the stationary state.
    void begin(std::uint32_t recording) noexcept;
    // The next sample, in whole counts of a 12-bit converter.
    double counts(double effort) noexcept;

  private:
    double next() noexcept;

    Parameters parameters_;
    std::uint64_t seed_;
    Stream electrode_;
    double a1_;
    double a2_;
    double innovation_;  // standard deviation of w
    std::uint32_t recording_ = 0;
    std::uint64_t sample_ = 0;
    double last_ = 0;
    double before_last_ = 0;
};

}  // namespace afferent
