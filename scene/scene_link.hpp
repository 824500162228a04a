// What a scene's link asks of packets.
#pragma once

#include "afferent/io/links/channel.hpp"
#include "afferent/io/wire/event_bus.hpp"
#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

PacketLayout packet_layout(const Scene& scene);

// Of the scene's channel; its random numbers follow from the scene's seed.
ChannelParameters channel_parameters(const proto::Channel& channel, std::uint64_t seed);

// Of the scene's bus, with that many neurons on it.
EventBusParameters bus_parameters(const proto::Bus& bus, Address addresses);

// Events are handed over as they are: no packets, no codec.
inline bool in_process(const proto::Link& link) {
    return link.transport_case() == proto::Link::TRANSPORT_NOT_SET || link.has_in_process();
}
inline bool in_process(const Scene& scene) { return in_process(scene.description().link()); }

// Messages may be lost, come twice, or out of order.
inline bool over_datagrams(const proto::Link& link) { return link.has_udp() || link.has_serial(); }

// Whether the grip is that of a simulated hand, which the gain then acts back on.
bool simulated_hand(const Scene& scene);
// Whether the samples come from the hand's side of the link.
bool hand_has_samples(const Scene& scene);

// Whether anything of the scene reads the decoder: the hand's gain, or what is recorded.
bool needs_decoder(const Scene& scene);

}  // namespace afferent
