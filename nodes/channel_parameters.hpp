// The emulated channel of a scene.
#pragma once

#include "afferent/io/links/channel.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Its random numbers follow from the scene's seed. Where the scene's link has none, it changes nothing.
ChannelParameters channel_parameters(const Scene& scene);
// The same the other way, with other random numbers; of each presentation of a trial its own.
ChannelParameters way_back_parameters(const Scene& scene, std::uint32_t presentation = 0);

}  // namespace afferent
