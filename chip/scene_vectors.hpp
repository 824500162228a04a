// A run of the scene as vectors: what its sensors read, and what the program made of it.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "afferent/chip/vectors.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent {

class SceneVectors {
  public:
    // All outlive it. The chip has encoder and wire.
    SceneVectors(const Plan& plan, const ChipNeurons& neurons, const ChipParts& parts);

    // As the run reports them. A force is taken as the lowest count of its converter that has it.
    void take(const Scan& scan);
    void take(std::span<const Event> events);

    Vectors vectors(TimePoint end) const;

  private:
    const ChipNeurons& neurons_;
    const ChipParts& parts_;
    std::vector<std::map<double, std::uint32_t>> counts_;             // by patch: of each force
    std::vector<std::size_t> patch_;                                  // by element
    std::map<std::pair<std::int64_t, Address>, std::uint32_t> read_;  // at that tick
    std::vector<VectorRecord> events_;
};

}  // namespace afferent
