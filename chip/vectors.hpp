// What a chip's neurons have to do: inputs, and the events and states that follow from them, to the bit.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "afferent/chip/chip_parts.hpp"
#include "afferent/chip/exported_file.hpp"

namespace afferent {

// One thing that happens at a tick: a reading and the input that follows from it, or an input alone, which
// are set before it; or what has to be there after it, an event or a state. The records of a tick come in
// that order, each kind by address.
struct VectorRecord {
    enum class Kind : std::uint8_t { reading, input, event, state };
    std::int64_t tick;  // the first is 1
    Kind kind;
    Address address;
    std::int64_t input = 0;  // or the reading
    FixedPointLif::State state = {};
};

struct Vectors {
    std::int64_t ticks = 0;
    std::vector<VectorRecord> records;
    // What goes onto a line after that tick, by ticks.
    struct Line {
        std::int64_t tick;
        std::vector<std::byte> bytes;
    };
    std::vector<Line> lines;
};

// Ticks of each of the parts that vectors have.
struct VectorLength {
    std::int64_t busy;
    std::int64_t silent;
    std::int64_t read;  // of readings, where the chip has an encoder

    // An hour of silence; fewer ticks where the neurons are many, or the ticks short.
    static VectorLength full(const ChipNeurons& neurons) noexcept;
    // As much as a simulation of a circuit gets through in seconds.
    static VectorLength of_simulation(const ChipNeurons& neurons) noexcept;
};

// Each neuron is driven by itself, at random by the seed: held and changing inputs, an input that changes at
// a spike, the largest and the smallest, inputs for which a rounding is a tie, or u just the threshold; the
// largest until g is, too; silence; once more what was first; and readings, every one if that many are asked
// for. `progress` is told of the part that is done.
Vectors chip_vectors(
    const ChipNeurons& neurons, const ChipParts& parts, std::uint64_t seed, const VectorLength& length,
    const std::function<void(double)>& progress = [](double) {});

// Puts the records into their order, and adds what their events are on a line, where the chip has a wire.
void add_lines(Vectors& vectors, const ChipNeurons& neurons, const ChipParts& parts);

// What compares an implementation's records with those: compare.c, Makefile and README.md.
std::vector<ExportedFile> export_vectors(const ChipNeurons& neurons, const std::string& scene);

// As text, a record on a line:
//
//     afferent-vectors 1 NEURONS TICKS
//     c TICK ADDRESS COUNTS
//     i TICK ADDRESS INPUT
//     e TICK ADDRESS
//     s TICK ADDRESS U G REFRACTORY
//     f TICK COUNT BYTES
//     z TICKS+1
void write(const Vectors& vectors, Address neurons, std::ostream& out);

}  // namespace afferent
