// Layouts for fuzz targets to choose from.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "afferent/io/wire/packet_layout.hpp"

namespace afferent {

inline const std::array<PacketLayout, 11> fuzz_layouts{{
    {.addresses = 9},
    {.addresses = 1},
    {.addresses = 9, .max_events = 3},
    {.addresses = 100'000, .tick = 1ms, .span = 20ms, .heartbeat = 20ms},
    {.addresses = 85'899'345, .max_events = 5'000},
    {.addresses = 1000, .tick = 1us, .span = 1ms, .encoding = Encoding::fixed_width},
    {.addresses = 9, .span = 1ms, .gathered_spans = 5, .max_events = 3},
    {.addresses = 9,
     .encoding = Encoding::predicted,
     .max_events = 20,
     .neurons = {{4, {}}, {5, {.delta_g = 0}}}},
    {.addresses = 3, .encoding = Encoding::predicted, .tolerance = 1ms, .neurons = {{3, {}}}},
    {.addresses = 3, .encoding = Encoding::predicted, .acknowledged = true, .neurons = {{3, {}}}},
    {.addresses = 9,
     .encoding = Encoding::predicted,
     .max_events = 5,
     .tolerance = 1ms,
     .acknowledged = true,
     .neurons = {{9, {}}}},
}};

inline const PacketLayout& fuzz_layout(std::uint8_t choice) {
    return fuzz_layouts[choice % fuzz_layouts.size()];
}

// Makes objects that are slow to construct once for each layout, instead of for every input. They must keep
// no state from one input to the next.
template <class Made>
Made& made_for_fuzz_layout(std::uint8_t choice) {
    static std::vector<Made> made(fuzz_layouts.begin(), fuzz_layouts.end());
    return made[choice % made.size()];
}

}  // namespace afferent
