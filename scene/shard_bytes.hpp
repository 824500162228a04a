// The memory of a shard, before it is built.
#pragma once

#include <cstddef>
#include <cstdint>

#include "afferent/scene/patch_plan.hpp"

namespace afferent {

// `count` afferents of the patch from the begin-th on, with their encoder: what Shard::bytes() of the shard
// will be before it has run, to within the few words that hold its parts together.
std::size_t shard_bytes(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count);

}  // namespace afferent
