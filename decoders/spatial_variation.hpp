// How much the rates of neighbouring afferents differ: the roughness of what slides over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "afferent/decoders/pressure_fit.hpp"
#include "afferent/decoders/readout.hpp"
#include "afferent/decoders/spike_trains.hpp"
#include "afferent/decoders/work_budget.hpp"

namespace afferent {

// The mean absolute difference of the rates of afferents 1 to 3 mm apart, which goes with the roughness that
// people report of coarse surfaces if the afferents are SA1: Connor, Hsiao, Phillips and Johnson (1990), J
// Neurosci 10:3823; Blake, Hsiao and Johnson (1997), J Neurosci 17:7480.
//
// A rate is the reciprocal of the interspike interval around a time, so that counting whole spikes adds
// nothing to it. Each afferent's mean over the window is subtracted: gains that differ, and the shape of the
// contact, are not rough. What makes intervals irregular adds to the roughness: noise of the neurons, and
// spikes that are lost.
//
// Allocates nothing after construction.
class SpatialVariation {
  public:
    static constexpr double nearest_mm = 1, farthest_mm = 3;
    // From one time at which rates are compared to the next.
    static constexpr Duration step = 10ms;
    // Afferents that have fired and have a neighbour that has. Fewer tell nothing.
    static constexpr std::size_t fewest = 4;

    SpatialVariation(const std::vector<SkinField>& fields, Duration window);

    // The next call of advance() begins with another window.
    void begin() noexcept;
    // As WaveFit::advance(), for what belongs to the roughness. Trains are sorted.
    bool advance(const SpikeTrains& trains, WorkBudget& budget, TextureEstimate& estimate) noexcept;

    bool has_neighbours() const noexcept { return !pairs_.empty(); }
    std::size_t heap_bytes() const noexcept;

  private:
    struct Pair {
        std::uint32_t one, other;
    };
    struct Sum {
        double hz = 0;
        std::size_t pairs = 0;
    };

    void add(const SpikeTrains& trains, const Pair& pair) noexcept;
    void tell(TextureEstimate& estimate) const noexcept;

    std::vector<Pair> pairs_;
    std::size_t steps_;
    std::vector<double> rates_;  // of each afferent at each time, less its mean
    std::vector<Sum> sums_;      // of each afferent's pairs
    std::size_t rated_ = 0;      // afferents whose rates are known
    std::size_t compared_ = 0;   // pairs
};

}  // namespace afferent
