// Whether a chip is the one that a scene describes.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/scene/plan.hpp"

namespace afferent {

// A number for all constants of its neurons and the layout of its packets; none where neurons are not
// fixed_point, or the link carries no packets.
std::optional<std::uint64_t> chip_fingerprint(const Plan& plan);

}  // namespace afferent
