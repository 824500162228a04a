// What the two nodes of a scene have to agree on, and where they meet.
#pragma once

#include "afferent/io/links/key_folder.hpp"
#include "afferent/io/links/link.hpp"
#include "afferent/io/links/link_address.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// The hello of a scene. Its nonce is new at every call.
proto::Hello make_hello(const Plan& plan, bool lockstep);

// In lockstep a peer may be silent for any length of time, and take its time before it says bye.
SessionLimits session_limits(const Plan& plan, bool lockstep);

// A coprocessor that has been silent until the hand is safe makes way for another. In lockstep it keeps its
// place, and nothing that is sent is dropped.
LinkOptions link_options(const Plan& plan, bool lockstep);

// Where the hand listens, with the keys that `end` needs to open it. An error where a key cannot be read,
// and where the scene's link does not leave the process.
Result<LinkAddress> hand_address(const Scene& scene, LinkEnd link_end);

// Where a node of that end listens or connects: at the hand's address, but for the coprocessor of a scene
// with a channel, which connects to `afferent channel`. An error, too, where the link may lose messages:
// lockstep waits for every one.
Result<LinkAddress> address_of(const Plan& plan, LinkEnd link_end, bool lockstep);

}  // namespace afferent
