// What the relay of a scene does with the frames between its two ends.
#pragma once

#include "afferent/io/links/link_address.hpp"
#include "afferent/io/links/relay.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Towards the hand, the scene's channel. Towards the coprocessor the same without fifo_events, and unless
// `both_ways`, with delays alone. `not_allowed` where fifo_events counts events that keys hide. The scene's
// link has a channel and leaves the process.
Result<RelayParameters> relay_parameters(const Plan& plan, const LinkAddress& hand, bool both_ways);

}  // namespace afferent
