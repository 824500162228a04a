// What the elements feel of the grip force, where it is not what the decoder is told.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

// The parts of the grip force that the elements feel in the presentation with that number. `stated`: what the
// scene says of them, by element. All elements are dead where more are asked for than there are.
std::vector<double> felt_shares(const scene::TrialSensing& sensing, std::vector<double> stated,
                                std::uint64_t seed, std::uint32_t number);

}  // namespace afferent
