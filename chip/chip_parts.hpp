// What a chip has beside its neurons.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "afferent/chip/chip_neurons.hpp"
#include "afferent/chip/counts_encoder.hpp"
#include "afferent/io/wire/packet_layout.hpp"

namespace afferent {

struct ChipParts {
    // Nothing: see why_no_encoder.
    std::optional<CountsEncoder> encoder = {};
    std::string why_no_encoder = {};
    // How its events go onto a line. Nothing: see why_no_wire.
    std::optional<PacketLayout> wire = {};
    std::vector<std::byte> hello = {};  // the frame on the line that says which chip it is
    std::string why_no_wire = {};
};

ChipParts chip_parts(const Plan& plan, const ChipNeurons& neurons);

// How many events a packet of the chip has at most: each neuron may fire at each tick.
std::uint64_t most_chip_events(const PacketLayout& layout, const ChipNeurons& neurons);

}  // namespace afferent
