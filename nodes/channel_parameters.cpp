#include "afferent/nodes/channel_parameters.hpp"

#include "afferent/hand/random.hpp"

namespace afferent {

ChannelParameters channel_parameters(const Scene& scene) {
    if (!scene.link.channel) return {};
    const scene::Channel& channel = *scene.link.channel;
    return {.bandwidth_bps = channel.bandwidth_bps,
            .latency = from_milliseconds(channel.latency_ms),
            .jitter = from_milliseconds(channel.jitter_ms),
            .loss = channel.loss,
            .reorder = channel.reorder,
            .duplicate = channel.duplicate,
            .corrupt = channel.corrupt,
            .fifo_events = channel.fifo_events,
            .drop_policy =
                channel.drop_policy == scene::DropPolicy::newest ? DropPolicy::newest : DropPolicy::oldest,
            .seed = scene.seed};
}

ChannelParameters way_back_parameters(const Scene& scene, std::uint32_t presentation) {
    ChannelParameters parameters = channel_parameters(scene);
    parameters.seed = random_seed(scene.seed, Stream::way_back, presentation);
    return parameters;
}

}  // namespace afferent
