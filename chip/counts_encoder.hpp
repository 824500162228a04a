// From a converter's counts to the inputs of a chip's neurons: in integers, and as the emulator has them.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/chip/chip_neurons.hpp"

namespace afferent {

// A curve from counts to the input of a neuron: force (by the sensor's curve or its calibration), drive, b.
// In pieces that are quotients of two linear functions, as the inverse of a force-sensitive resistor in a
// divider is one; the pieces are as long as no count's input differs from the emulator's.
struct CountsCurve {
    // From `begin` to the next piece's: input = offset + (p·x + q) / (s·x + r), rounded down, with
    // x = counts − begin. Dividend and divisor are positive and below 2^62.
    struct Piece {
        std::uint32_t begin = 0;
        std::int64_t offset = 0;
        std::int64_t p = 0;
        std::int64_t q = 0;
        std::int64_t s = 0;
        std::int64_t r = 1;

        std::int64_t input(std::uint32_t counts) const noexcept;
        friend bool operator==(const Piece&, const Piece&) = default;
    };
    std::uint32_t highest_count = 0;  // larger counts count as this
    std::vector<Piece> pieces;

    std::int64_t input(std::uint32_t counts) const noexcept;
    friend bool operator==(const CountsCurve&, const CountsCurve&) = default;
};

struct CountsEncoder {
    std::vector<CountsCurve> curves;   // each once
    std::vector<std::uint32_t> curve;  // by address

    const CountsCurve& curve_of(Address address) const noexcept { return curves[curve[address]]; }
};

// The force of each count of an element's converter, as the scene takes it.
std::vector<double> forces_of_counts(const PatchPlan& patch, std::uint32_t element);

// The plan has to have chip_neurons(). Each afferent reads the element of its own address. Throws SceneError
// if a patch is not sustained, reads the elements of another patch, or has receptive fields; and if a curve
// needs more than 1,024 pieces.
CountsEncoder counts_encoder(const Plan& plan);

}  // namespace afferent
