// How likely a foreseen spike comes in each tick, in integers: the same on every machine.
#pragma once

#include <array>
#include <bit>
#include <cassert>
#include <cstdint>

namespace afferent {

// How far spikes are from where they were foreseen follows Student's distribution with two degrees of
// freedom, scaled by a spread that follows each afferent's own misses:
//
//     F(z) = (1 + z/√(2 + z²)) / 2
//
// Its tails are those of forces that hold, and now and then do not; and it needs a square root alone.
// Distances are in sixteenths of a tick, spreads in eighths.
class SpikeChances {
  public:
    static constexpr std::uint32_t scale = std::uint32_t{1} << 17;

    // Requires spread > 0, and rounds it to a quarter of an octave, so that until() needs no division.
    explicit SpikeChances(std::uint32_t spread) noexcept {
        assert(spread > 0);
        const auto octave = static_cast<std::uint32_t>(std::bit_width(spread)) - 1;
        reciprocal_ = reciprocals[(spread << 2 >> octave) & 3];
        shift_ = octave + 15;
    }

    // F(distance/spread), in 1/scale.
    std::uint32_t until(std::int64_t distance) const noexcept {
        const std::uint32_t tail = beyond(static_cast<std::uint64_t>(distance < 0 ? -distance : distance));
        return distance < 0 ? tail : scale - tail;
    }

    // The spread after a miss.
    static std::uint32_t after(std::uint32_t spread, std::uint32_t miss) noexcept {
        // One wild miss says little about the next.
        const auto counted =
            static_cast<std::int64_t>(miss / 2 < 4 * spread + 64 ? miss / 2 : 4 * spread + 64);
        const std::int64_t next = spread + ((counted - std::int64_t{spread}) >> 2);
        return static_cast<std::uint32_t>(next < 1 ? 1 : next > most_spread ? most_spread : next);
    }

    static constexpr std::int64_t most_spread = 0xffff;

  private:
    // F(−z) at sixteenths of z, up to 128.
    static constexpr std::uint32_t points = 2048;
    static constexpr std::array<std::uint32_t, points + 1> tails = [] {
        std::array<std::uint32_t, points + 1> found{};
        for (std::uint64_t i = 0; i <= points; ++i) {
            // z/√(2 + z²) in 2^-20, from its square in 2^-40.
            const std::uint64_t square = (i * i << 40) / (512 + i * i);
            std::uint64_t root = 0;
            for (std::uint64_t bit = std::uint64_t{1} << 20; bit > 0; bit >>= 1)
                if ((root + bit) * (root + bit) <= square) root += bit;
            found[i] = static_cast<std::uint32_t>(((std::uint64_t{1} << 20) - root) >> 4);
        }
        return found;
    }();

    static constexpr std::array<std::uint32_t, 4> reciprocals = {(1U << 26) / 4, (1U << 26) / 5,
                                                                 (1U << 26) / 6, (1U << 26) / 7};

    std::uint32_t beyond(std::uint64_t distance) const noexcept {
        // z in 2^-10: 2^10 · distance / (2 · spread).
        const std::uint64_t z = distance * reciprocal_ >> shift_;
        const std::uint64_t index = z >> 6;
        if (index >= points) return tails[points];
        const std::uint32_t high = tails[index];
        return high - static_cast<std::uint32_t>((high - tails[index + 1]) * (z & 63) >> 6);
    }

    std::uint64_t reciprocal_;
    std::uint32_t shift_;
};

}  // namespace afferent
