// The times of a scene's link.
#pragma once

#include "afferent/runtime/time.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct LinkTiming {
    Duration tick;
    Duration packet;
    Duration delivery;
    Duration overtaking;  // how long a packet waits for those that it has overtaken
    Duration stale;       // the age from which on a packet is not used
    Duration heartbeat;
    Duration freeze;
    Duration safe;
};

LinkTiming link_timing(const scene::Link& link);

}  // namespace afferent
