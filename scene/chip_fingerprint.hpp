// Whether a chip is the one that a scene describes.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/scene/plan.hpp"

namespace afferent {

// A number that stands for all constants of the chip's neurons, for what they make of a converter's counts,
// and for the layout of its packets. Nothing where neurons are not fixed_point, or the link carries no
// packets.
std::optional<std::uint64_t> chip_fingerprint(const Plan& plan);

}  // namespace afferent
