// What every encoder is: it turns an element's samples into its neuron's drive.
#pragma once

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
    slope,   // the size of the force's rate of change, in N/s
    change,  // the size of the change of that rate, in N/s²
};

}  // namespace afferent
