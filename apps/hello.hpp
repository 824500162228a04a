// What the two processes of a scene have to agree on, and where they meet.
#pragma once

#include "afferent/io/link_address.hpp"
#include "afferent/proto/aer.pb.h"
#include "afferent/scene/scene.hpp"

namespace afferent {

// The hello of a scene. Its nonce is new at every call.
proto::Hello make_hello(const Scene& scene, bool lockstep);

// With the keys that the scene names. Throws Failure where they cannot be read, where the scene's link does
// not leave the process or emulates a channel, and where it may lose what lockstep waits for.
LinkAddress address_of(const Scene& scene, bool lockstep);

}  // namespace afferent
