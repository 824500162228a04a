// What the two processes of a scene have to agree on, and where they meet.
#pragma once

#include "afferent/io/links/key_folder.hpp"
#include "afferent/io/links/link_address.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/proto/aer.pb.h"
#include "afferent/scene/scene.hpp"

namespace afferent {

// The hello of a scene. Its nonce is new at every call.
proto::Hello make_hello(const Scene& scene, bool lockstep);

// In lockstep a peer may be silent for as long as it likes.
SessionLimits session_limits(bool lockstep);

// Where the hand listens, and what that side opens it with: the keys that the scene names. Throws Failure
// where they cannot be read, and where the scene's link does not leave the process.
LinkAddress hand_address(const Scene& scene, LinkSide side);

// Where that side goes: the coprocessor of a scene with a channel to `afferent channel`, otherwise to the
// hand. Throws Failure also where the link may lose what lockstep waits for.
LinkAddress address_of(const Scene& scene, LinkSide side, bool lockstep);

}  // namespace afferent
