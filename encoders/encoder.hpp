// What every encoder is: it turns an element's samples into its neuron's drive.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <optional>

#include "afferent/runtime/time.hpp"

namespace afferent {

// drive_mv() is the drive in mV from this sample to the next. Sample times of an element increase. The
// constructor throws ParameterError.
template <class E>
concept Encoder = requires(const E& encoder, typename E::State& state, TimePoint time, double force_n) {
    requires std::default_initializable<typename E::State>;
    E(typename E::Parameters{});
    { encoder.drive_mv(state, time, force_n) } -> std::same_as<double>;
};

// What an encoder multiplies by its gain.
enum class EncoderInput {
    force,   // in N
    slope,   // the force's rate of change, rectified, in N/s
    change,  // the change of that rate, rectified, in N/s²
};

//     rectified(x) = max(0, |x| − threshold)         x > 0
//                    the same · negative_ratio       x < 0
//
// A ratio of 1 is full-wave rectification, which answers a sine twice a cycle, 0 half-wave rectification; the
// threshold is an input that does not drive at all. The defaults give |x| to the bit.
struct Rectification {
    double negative_ratio = 1;
    double threshold = 0;

    // Throws ParameterError: 0 <= negative_ratio <= 1, threshold >= 0 and finite, which has that name.
    void check(const char* threshold_name) const;

    // No input of that size or less gives more.
    double largest(double size) const noexcept { return std::max(0.0, size - threshold); }
    // rectified(change / time) · time, without the division, whose rounding would change results.
    double operator()(double change, double time = 1) const noexcept {
        return std::max(0.0, std::abs(change) - threshold * time) * (change < 0 ? negative_ratio : 1);
    }
    bool operator==(const Rectification&) const = default;
};

}  // namespace afferent
