#include "afferent/scene/scene_link.hpp"

namespace afferent {

PacketLayout packet_layout(const Scene& scene) {
    const proto::Link& link = scene.description().link();
    const LinkTiming timing = link_timing(link);
    return {.addresses = scene.addresses(),
            .tick = timing.tick,
            .span = timing.packet,
            .heartbeat = timing.heartbeat,
            .encoding = link.encoding() == proto::FIXED_WIDTH ? Encoding::fixed_width : Encoding::rice,
            .max_events = link.packet_events()};
}

ChannelParameters channel_parameters(const proto::Channel& channel, std::uint64_t seed) {
    return {
        .bandwidth_bps = channel.bandwidth_bps(),
        .latency = from_milliseconds(channel.latency_ms()),
        .jitter = from_milliseconds(channel.jitter_ms()),
        .loss = channel.loss(),
        .reorder = channel.reorder(),
        .duplicate = channel.duplicate(),
        .corrupt = channel.corrupt(),
        .fifo_events = channel.fifo_events(),
        .drop_policy = channel.drop_policy() == proto::DROP_NEWEST ? DropPolicy::newest : DropPolicy::oldest,
        .seed = seed};
}

EventBusParameters bus_parameters(const proto::Bus& bus, Address addresses) {
    return {.addresses = addresses,
            .cycle = Duration(bus.cycle_ns()),
            .rows = bus.rows(),
            .row_events = bus.row_events()};
}

bool simulated_hand(const Scene& scene) {
    const proto::Source& source = scene.description().source();
    return source.has_simulated_hand() || source.kind_case() == proto::Source::KIND_NOT_SET;
}

bool hand_has_samples(const Scene& scene) {
    return simulated_hand(scene) || scene.description().source().has_link();
}

bool needs_decoder(const Scene& scene) {
    return simulated_hand(scene) || scene.description().record().force() ||
           scene.description().record().picture();
}

}  // namespace afferent
