// What every encoder is: from an element's samples to its neuron's drive.
#pragma once

#include <concepts>

#include "afferent/runtime/time.hpp"

namespace afferent {

// The drive in mV that holds from this sample to the next. Sample times of an element increase.
template <class E>
concept Encoder = requires(const E& encoder, typename E::State& state, TimePoint time, double force_n) {
    requires std::default_initializable<typename E::State>;
    { encoder.drive_mv(state, time, force_n) } -> std::same_as<double>;
};

}  // namespace afferent
