// The emulated channel of a scene.
#pragma once

#include "afferent/io/links/channel.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Its random numbers follow from the scene's seed. The scene's link has a channel.
ChannelParameters channel_parameters(const Scene& scene);

}  // namespace afferent
