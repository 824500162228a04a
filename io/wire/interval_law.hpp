// When a neuron fires next by its own law, in integers: the same on every machine.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "afferent/io/wire/neuron_law.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// With W = v_th − E_k, w₀ = v_r − E_k and b the drive over E_k, a neuron whose adaptation was g after a spike
// fires again after t where
//
//     b/W = (1 − w₀/W · Φ(t, g)) / Ψ(t, g)
//
// which falls as t grows: one table of it, over t and g in steps of an eighth and a quarter of an octave,
// gives the drive of an interval and the interval of a drive. Between its points both are linear, so that a
// drive that is held gives its own interval back. The table is for foreseeing spikes, not for computing them:
// it is right to 1 % of the interval or so.
//
// Units: t in sixteenths of a tick, g in 2^-16, drives b/W in 2^-24; each saturates.
class IntervalLaw {
  public:
    // The parameters are those that a neuron of a checked scene may have.
    IntervalLaw(const NeuronLaw& law, Duration tick);

    // No interval is foreseen that is longer, in ticks.
    static constexpr std::uint32_t longest = std::uint32_t{1} << 20;

    // Under which drive the interval after a spike with adaptation g is so long.
    std::uint32_t drive(std::uint32_t interval, std::uint32_t g) const noexcept;
    // How long it is under a drive; 0: longer than any that is foreseen. `near`, where it is looked for
    // first, changes nothing but the time that it takes.
    std::uint32_t interval(std::uint32_t drive, std::uint32_t g, std::uint32_t near = 0) const noexcept;
    // The adaptation after the first spike, and after one that comes so many ticks after one with g.
    std::uint32_t first_adaptation() const noexcept { return jump_; }
    std::uint32_t next_adaptation(std::uint32_t g, std::uint32_t ticks) const noexcept;

  private:
    struct Row {
        const std::uint32_t* below;
        const std::uint32_t* above;
        std::uint32_t part;  // of the way from one to the other, in 2^-16

        std::uint32_t drive(std::uint32_t column) const noexcept;
    };

    Row row(std::uint32_t g) const noexcept;
    void fill_row(std::uint32_t g, double tick_ms, const NeuronLaw& law, std::uint32_t* row) const;

    std::uint32_t jump_;
    std::uint32_t most_g_;
    std::uint32_t refractory_;     // in sixteenths of a tick
    std::uint32_t first_row_ = 0;  // of those of all g
    // e^(−n·tick/tau_g) in 2^-32: n below 64, multiples of 64, and of 4096.
    std::array<std::array<std::uint32_t, 64>, 3> decay_;
    std::vector<std::uint32_t> drives_;  // row after row
};

}  // namespace afferent
