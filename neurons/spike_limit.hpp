// The guard against spike storms: a drive far beyond the sensor's range ends the run with an error instead of
// hanging it.
#pragma once

#include <cstdint>
#include <limits>

#include "afferent/runtime/time.hpp"

namespace afferent {

// No neuron may fire more than `spikes` times in one window. Windows are counted from scene_start, so the
// guard acts at the same spike however the run is divided into calls.
struct SpikeLimit {
    std::uint32_t spikes = std::numeric_limits<std::uint32_t>::max();
    Duration window = 5ms;
};

// The neuron that exceeded the limit, and when.
struct SpikeStorm {
    std::uint32_t index;
    TimePoint time;
};

}  // namespace afferent
