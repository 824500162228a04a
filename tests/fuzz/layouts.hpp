// Layouts for fuzz targets to choose from.
#pragma once

#include <array>

#include "afferent/io/packet_layout.hpp"

namespace afferent {

inline PacketLayout fuzz_layout(std::uint8_t choice) {
    static const std::array<PacketLayout, 6> layouts{{
        {.addresses = 9},
        {.addresses = 1},
        {.addresses = 9, .max_events = 3},
        {.addresses = 100'000, .tick = 1ms, .span = 20ms, .heartbeat = 20ms},
        {.addresses = 85'899'345, .max_events = 50'000},
        {.addresses = 1000, .tick = 1us, .span = 1ms, .encoding = Encoding::fixed_width},
    }};
    return layouts[choice % layouts.size()];
}

}  // namespace afferent
