// The neurons of a population: one for all, or each with its own parameters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "afferent/neurons/neuron.hpp"

namespace afferent {

// All neurons alike, so nothing is stored for each. They may differ in the phase at which they begin.
template <Neuron N>
class Alike {
  public:
    explicit Alike(N neuron, Phases phases = {}) : neuron_(std::move(neuron)), phases_(std::move(phases)) {}
    const N& operator[](std::uint32_t) const noexcept { return neuron_; }
    typename N::State start(std::uint32_t index) const {
        return phases_ ? neuron_.at_phase(phases_(index)) : neuron_.rest();
    }
    static constexpr std::size_t bytes(std::size_t) noexcept { return 0; }

  private:
    N neuron_;
    Phases phases_;
};

// Each neuron with its own parameters, any of which may differ, and its own beginning.
template <Neuron N>
class Individual {
  public:
    // Takes one set of parameters for each neuron. Throws ParameterError.
    explicit Individual(std::span<const typename N::Parameters> parameters, Phases phases = {})
        : phases_(std::move(phases)) {
        neurons_.reserve(parameters.size());
        for (const typename N::Parameters& each : parameters) neurons_.emplace_back(each);
    }
    const N& operator[](std::uint32_t index) const noexcept { return neurons_[index]; }
    typename N::State start(std::uint32_t index) const {
        return phases_ ? neurons_[index].at_phase(phases_(index)) : neurons_[index].rest();
    }
    static constexpr std::size_t bytes(std::size_t count) noexcept { return count * sizeof(N); }

  private:
    std::vector<N> neurons_;
    Phases phases_;
};

}  // namespace afferent
