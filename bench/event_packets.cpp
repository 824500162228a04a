#include "bench/event_packets.hpp"

#include <algorithm>
#include <stdexcept>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"

namespace afferent {
namespace {

// Calls sink(packet, deadline) for each packet.
template <class Sink>
void packetize(const LinkActivity& activity, const PacketLayout& layout, const Sink& sink) {
    Packetizer packetizer(layout);
    const TimePoint end = scene_start + activity.duration;
    auto first = activity.events.begin();
    for (TimePoint deadline = scene_start + layout.span; deadline <= end; deadline += layout.span) {
        const auto last = std::partition_point(
            first, activity.events.end(), [deadline](const Event& event) { return event.time < deadline; });
        packetizer.push({first, last});
        packetizer.close(deadline, [&](const proto::Envelope& packet) { sink(packet, deadline); });
        first = last;
    }
    packetizer.finish(end, [&](const proto::Envelope& packet) { sink(packet, end); });
}

}  // namespace

PacketLayout event_layout(const LinkActivity& activity, Duration tick, Duration deadline,
                          std::optional<Duration> tolerance) {
    PacketLayout layout{.addresses = activity.addresses,
                        .tick = tick,
                        .span = deadline,
                        .heartbeat = std::max(link_heartbeat, deadline),
                        .max_events = 50'000};
    if (!tolerance) return layout;
    layout.encoding = Encoding::predicted;
    layout.tolerance = *tolerance;
    layout.neurons = activity.neurons;
    // Room for 500 events/s of each afferent, as far as a message has it.
    const auto of_each = static_cast<std::uint32_t>(std::max<Duration::rep>(4, deadline / 2ms));
    layout.max_events = std::min(activity.addresses * of_each, 40'000U);
    return layout;
}

std::uint64_t event_bytes(const LinkActivity& activity, const PacketLayout& layout) {
    FrameWriter writer;
    std::uint64_t bytes = 0;
    packetize(activity, layout,
              [&](const proto::Envelope& packet, TimePoint) { bytes += writer.stream_frame(packet).size(); });
    return bytes;
}

std::vector<ToldSpan> told_spans(const LinkActivity& activity, const PacketLayout& layout) {
    PacketReceiver receiver(layout);
    std::vector<ToldSpan> told;
    bool continues = false;
    packetize(activity, layout, [&](const proto::Envelope& packet, TimePoint closes) {
        const Result<Reception> received = receiver.receive(packet);
        if (!received) throw std::runtime_error("a packet is not understood: " + received.error().text);
        const Reception& reception = received.value();
        if (!continues) told.push_back({reception.known.begin, reception.known.end, closes, {}});
        std::vector<Event>& events = told.back().events;
        events.insert(events.end(), reception.events.begin(), reception.events.end());
        continues = reception.more;
    });
    return told;
}

}  // namespace afferent
