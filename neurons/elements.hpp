// The neurons of a population: one for all, or each with its own parameters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "afferent/neurons/neuron.hpp"

namespace afferent {

// All neurons alike, so nothing is stored for each.
template <Neuron N>
class Alike {
  public:
    static constexpr std::size_t bytes_per_neuron = 0;

    explicit Alike(N neuron, std::size_t) : neuron_(std::move(neuron)) {}
    const N& operator[](std::uint32_t) const noexcept { return neuron_; }

  private:
    N neuron_;
};

// Each neuron with its own parameters; any of them may differ.
template <Neuron N>
class Individual {
  public:
    static constexpr std::size_t bytes_per_neuron = sizeof(N);

    // One set of parameters for each neuron. Throws ParameterError.
    explicit Individual(std::span<const typename N::Parameters> parameters) {
        neurons_.reserve(parameters.size());
        for (const typename N::Parameters& each : parameters) neurons_.emplace_back(each);
    }
    const N& operator[](std::uint32_t index) const noexcept { return neurons_[index]; }
    std::size_t size() const noexcept { return neurons_.size(); }

  private:
    std::vector<N> neurons_;
};

}  // namespace afferent
