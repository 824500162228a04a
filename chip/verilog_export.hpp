// A scene's neurons in synthesizable Verilog-2001: one core whose arithmetic all neurons
// share, state in block RAM.
#pragma once

#include <string>
#include <vector>

#include "afferent/chip/chip_neurons.hpp"
#include "afferent/chip/exported_file.hpp"

namespace afferent {

// afferent_chip.v, afferent_test.v (which compares it with vectors), Makefile and README.md.
// `scene` is its name, for people.
std::vector<ExportedFile> export_verilog(const ChipNeurons& neurons, const std::string& scene);

// Cycles of the clock that a tick takes, from one to the next.
std::uint64_t exported_cycles_per_tick(const ChipNeurons& neurons);

}  // namespace afferent
