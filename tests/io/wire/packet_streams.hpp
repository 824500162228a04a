// Events into packets and back, without a link.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "tests/since_start.hpp"

namespace afferent {

inline PacketLayout layout_of(Address addresses) {
    PacketLayout layout;
    layout.addresses = addresses;
    return layout;
}

inline std::vector<Event> random_events(std::mt19937_64& random, const PacketLayout& layout,
                                        std::size_t count, Duration duration) {
    std::vector<Event> events(count);
    for (Event& event : events)
        event = {at(Duration(random() % static_cast<std::uint64_t>(duration.count()))),
                 static_cast<Address>(random() % layout.addresses)};
    std::sort(events.begin(), events.end());
    return events;
}

// As the receiver will see them: at the begin of their ticks, sorted.
inline std::vector<Event> on_ticks(std::vector<Event> events, Duration tick) {
    for (Event& event : events) event.time -= (event.time - scene_start) % tick;
    std::sort(events.begin(), events.end());
    return events;
}

inline std::vector<proto::Envelope> packets_of(const PacketLayout& layout, const std::vector<Event>& events,
                                               TimePoint end) {
    Packetizer packetizer(layout);
    std::vector<proto::Envelope> packets;
    packetizer.push(events);
    packetizer.finish(end, [&](const proto::Envelope& packet) { packets.push_back(packet); });
    EXPECT_EQ(packetizer.packets(), packets.size());
    EXPECT_EQ(packetizer.events(), events.size());
    return packets;
}

struct Received {
    std::vector<Event> events;
    std::vector<TimeSpan> known;
    std::vector<TimeSpan> gaps;
};

inline void take(Received& received, const Reception& reception) {
    received.events.insert(received.events.end(), reception.events.begin(), reception.events.end());
    received.known.push_back(reception.known);
    if (reception.gap) received.gaps.push_back(*reception.gap);
}

inline Received receive_all(PacketReceiver& receiver, const std::vector<proto::Envelope>& packets) {
    Received received;
    for (const auto& packet : packets) {
        const Result<Reception> reception = receiver.receive(packet);
        EXPECT_TRUE(reception) << reception.error().text;
        if (reception) take(received, reception.value());
    }
    return received;
}

}  // namespace afferent
