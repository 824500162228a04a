// Question: what does a neuron in silicon cost, and how wrong is it, for each width and tick?
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

namespace afferent::bench {

struct ChipBench {
    std::filesystem::path out;
    bool quick = false;
    std::filesystem::path scene = "examples/chip.txtpb";
    std::function<void(double)> progress = [](double) {};  // is told of the part that is done
};

// For 8, 12, 16 and 24 bits on ticks of 0.1 and 1 ms: the error of spike times and of the force, as bench
// error has them on the grasp; instructions of the exported C for a neuron and tick on a Cortex-M3, as QEMU
// counts them, most beside typical; bytes of the scene's exported C on a Cortex-M0; and logic cells, block
// RAMs, the highest clock and the lowest that is enough for a core of 256 neurons on an iCE40 HX8K. What
// needs a program that is not installed is left out, and said.
//
// Writes chip.csv and the pictures chip.svg and chip.png, and what was exported into folders; prints the
// table. Throws std::runtime_error where a program fails or a file cannot be written.
void run_chip_bench(const ChipBench& bench, std::ostream& report);

}  // namespace afferent::bench
