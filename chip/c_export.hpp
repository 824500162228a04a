// A scene's coprocessor in C99, for a microcontroller: integers, static memory, nothing but <stdint.h>.
#pragma once

#include <string>
#include <vector>

#include "afferent/chip/chip_parts.hpp"
#include "afferent/chip/exported_file.hpp"

namespace afferent {

// afferent_chip.h, afferent_chip.c, check.c (which compares them with vectors), cortex_m.c (which begins it
// on a Cortex-M), Makefile and README.md; and afferent_encoder and afferent_wire, .h and .c, where the chip
// has those parts. `scene` is its name, for people.
std::vector<ExportedFile> export_c(const ChipNeurons& neurons, const ChipParts& parts,
                                   const std::string& scene);

// Bytes of RAM that the exported code takes for each neuron.
std::uint32_t exported_bytes_per_neuron(const ChipNeurons& neurons);

}  // namespace afferent
