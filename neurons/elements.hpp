// The neurons of a population: one for all, or each with its own parameters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "afferent/neurons/neuron.hpp"

namespace afferent {

// All neurons alike, so nothing is stored for each but the phase at which it begins, if they differ in that.
template <Neuron N>
class Alike {
  public:
    explicit Alike(N neuron, std::size_t, std::span<const double> phases = {})
        : neuron_(std::move(neuron)), phases_(phases.begin(), phases.end()) {}
    const N& operator[](std::uint32_t) const noexcept { return neuron_; }
    typename N::State start(std::uint32_t index) const noexcept {
        return phases_.empty() ? neuron_.rest() : neuron_.at_phase(phases_[index]);
    }
    std::size_t bytes() const noexcept { return size_of(0, phases_.size()); }
    static constexpr std::size_t size_of(std::size_t, std::size_t phases) noexcept {
        return phases * sizeof(double);
    }

  private:
    N neuron_;
    std::vector<double> phases_;
};

// Each neuron with its own parameters, any of which may differ, and its own beginning.
template <Neuron N>
class Individual {
  public:
    // One set of parameters for each neuron, and the phase at which it begins, in [0, 1); without phases all
    // begin at rest. Throws ParameterError.
    explicit Individual(std::span<const typename N::Parameters> parameters,
                        std::span<const double> phases = {})
        : phases_(phases.begin(), phases.end()) {
        neurons_.reserve(parameters.size());
        for (const typename N::Parameters& each : parameters) neurons_.emplace_back(each);
    }
    const N& operator[](std::uint32_t index) const noexcept { return neurons_[index]; }
    typename N::State start(std::uint32_t index) const noexcept {
        return phases_.empty() ? neurons_[index].rest() : neurons_[index].at_phase(phases_[index]);
    }
    std::size_t size() const noexcept { return neurons_.size(); }
    std::size_t bytes() const noexcept { return size_of(neurons_.size(), phases_.size()); }
    static constexpr std::size_t size_of(std::size_t count, std::size_t phases) noexcept {
        return count * sizeof(N) + phases * sizeof(double);
    }

  private:
    std::vector<N> neurons_;
    std::vector<double> phases_;
};

}  // namespace afferent
