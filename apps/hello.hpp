// What the two processes of a scene have to agree on, and where they meet.
#pragma once

#include "afferent/io/link_address.hpp"
#include "afferent/io/session.hpp"
#include "afferent/proto/aer.pb.h"
#include "afferent/scene/scene.hpp"

namespace afferent {

// The hello of a scene. Its nonce is new at every call.
proto::Hello make_hello(const Scene& scene, bool lockstep);

// In lockstep a peer may be silent for as long as it likes.
SessionLimits session_limits(bool lockstep);

// Throws Failure where the scene's link does not leave the process, or emulates a channel.
LinkAddress address_of(const Scene& scene);

}  // namespace afferent
