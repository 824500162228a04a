// What a chip's neurons have to do: inputs, and the events and states that follow from them, to the bit.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <vector>

#include "afferent/chip/chip_neurons.hpp"

namespace afferent {

// One thing that happens at a tick: an input, which is set before it; or what has to be there after it, an
// event or a state. The records of a tick come in that order, each kind by address.
struct VectorRecord {
    enum class Kind : std::uint8_t { input, event, state };
    std::int64_t tick;  // the first is 1
    Kind kind;
    Address address;
    std::int64_t input = 0;
    FixedPointLif::State state = {};
};

struct Vectors {
    std::int64_t ticks = 0;
    std::vector<VectorRecord> records;
};

// Ticks of each of the parts that vectors have.
struct VectorLength {
    std::int64_t busy;
    std::int64_t silent;

    // An hour of silence; fewer ticks where the neurons are many, or the ticks short.
    static VectorLength full(const ChipNeurons& neurons) noexcept;
    // As much as a simulation of a circuit gets through in seconds.
    static VectorLength of_simulation(const ChipNeurons& neurons) noexcept;
};

// Each neuron is driven by itself, at random by the seed: held and changing inputs, an input that changes at
// a spike, the largest and the smallest, inputs for which a rounding is a tie, or u just the threshold; the
// largest until g is, too; silence; and once more what was first. `progress` is told of the part that is
// done.
Vectors chip_vectors(
    const ChipNeurons& neurons, std::uint64_t seed, const VectorLength& length,
    const std::function<void(double)>& progress = [](double) {});

// As text, a record on a line:
//
//     afferent-vectors 1 NEURONS TICKS
//     i TICK ADDRESS INPUT
//     e TICK ADDRESS
//     s TICK ADDRESS U G REFRACTORY
//     z TICKS+1
void write(const Vectors& vectors, Address neurons, std::ostream& out);

}  // namespace afferent
