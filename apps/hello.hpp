// What the two processes of a scene have to agree on, and the addresses at which they meet.
#pragma once

#include "afferent/io/links/key_folder.hpp"
#include "afferent/io/links/link_address.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/proto/aer.pb.h"
#include "afferent/scene/scene.hpp"

namespace afferent {

// The hello of a scene. Its nonce is new at every call.
proto::Hello make_hello(const Scene& scene, bool lockstep);

// In lockstep a peer may be silent for any length of time.
SessionLimits session_limits(bool lockstep);

// The address at which the hand listens, with the keys of that side where the scene names some. Throws
// Failure where the keys cannot be read, or the scene's link is within one process.
LinkAddress hand_address(const Scene& scene, LinkSide side);

// The address that this side opens: the hand's, but for the coprocessor of a scene with a channel that of
// `afferent channel`. Throws Failure also where the link may lose what lockstep waits for.
LinkAddress address_of(const Scene& scene, LinkSide side, bool lockstep);

}  // namespace afferent
