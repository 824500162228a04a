// Packets through a channel with every fault at once: at the end each event was delivered, or lies in a
// reported gap.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <random>

#include "afferent/io/links/channel.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"

namespace afferent {
namespace {

// A few thousand in every run; AFFERENT_SOAK_PACKETS=10000000 for a night.
std::uint64_t packets_to_send() {
    const char* wanted = std::getenv("AFFERENT_SOAK_PACKETS");
    return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 20'000;
}

TEST(Soak, AccountsForEveryEventThroughEveryFault) {
    PacketLayout layout;
    layout.addresses = 9;
    layout.max_events = 6;  // so that there are parts
    // 5 kB/s carry the average traffic, and not a burst.
    Channel channel({.bandwidth_bps = 40'000,
                     .latency = 4ms,
                     .jitter = 9ms,
                     .loss = 0.05,
                     .reorder = 0.05,
                     .duplicate = 0.05,
                     .corrupt = 0.05,
                     .fifo_events = 60});
    Packetizer packetizer(layout);
    PacketReceiver receiver(layout);
    FrameWriter writer;
    FrameCounts counts;
    proto::Envelope message;
    std::mt19937_64 random(1);

    // Events neither delivered nor lost yet, on their ticks, sorted.
    std::vector<Event> open;
    std::deque<TimeSpan> gaps;
    std::uint64_t in_gaps = 0;
    std::uint64_t delivered = 0;
    const auto receive = [&](const Reception& reception) {
        for (const Event& event : reception.events) {
            const auto found = std::lower_bound(open.begin(), open.end(), event);
            ASSERT_TRUE(found != open.end() && *found == event) << "an event that was never sent";
            open.erase(found);
            ++delivered;
        }
        if (reception.gap) gaps.push_back(*reception.gap);
        // Events before this packet will not come any more.
        const auto older = std::partition_point(
            open.begin(), open.end(), [&](const Event& e) { return e.time < reception.known.begin; });
        for (auto event = open.begin(); event != older; ++event) {
            while (!gaps.empty() && gaps.front().end <= event->time) gaps.pop_front();
            ASSERT_TRUE(!gaps.empty() && gaps.front().begin <= event->time) << "a missing event is in no gap";
            ++in_gaps;
        }
        open.erase(open.begin(), older);
    };
    const auto arrive = [&](TimePoint until) {
        while (channel.next_arrival(until)) {
            if (!read_datagram(channel.arrive(), message, counts)) continue;
            const Result<Reception> reception = receiver.receive(message);
            if (reception)
                receive(reception.value());
            else
                ASSERT_EQ(reception.error().kind, Error::Kind::out_of_order) << reception.error().text;
        }
    };

    const std::uint64_t packets = packets_to_send();
    std::vector<Event> events;
    TimePoint deadline = scene_start;
    std::uint64_t sent_events = 0;
    while (packetizer.packets() < packets) {
        events.clear();
        // Silence, touch and bursts.
        const std::uint64_t mood = random() % 100;
        const std::uint64_t count = mood < 30 ? 0 : mood < 95 ? random() % 5 : random() % 40;
        for (std::uint64_t i = 0; i < count; ++i)
            events.push_back({deadline + (random() % 50) * layout.tick, static_cast<Address>(random() % 9)});
        std::sort(events.begin(), events.end());
        open.insert(open.end(), events.begin(), events.end());
        sent_events += count;
        packetizer.push(events);
        deadline += layout.span;
        packetizer.close(deadline, [&](const proto::Envelope& packet) {
            channel.send(deadline, writer.datagram(packet), packet.payload().empty() ? 0 : layout.max_events);
        });
        arrive(deadline);
        ASSERT_FALSE(HasFatalFailure());
    }
    packetizer.finish(
        deadline, [&](const proto::Envelope& packet) { channel.send(deadline, writer.datagram(packet), 0); });
    arrive(TimePoint::max());
    if (const auto gap = receiver.finish(deadline, sent_events))
        receive({.gap = gap, .known = {gap->end, gap->end}, .events = {}, .more = false});

    EXPECT_EQ(receiver.counts().events, delivered);
    EXPECT_EQ(delivered + in_gaps, sent_events);
    EXPECT_EQ(receiver.counts().lost_events, in_gaps);
    EXPECT_EQ(receiver.end(), deadline);
    EXPECT_EQ(counts.checksum_failures + receiver.counts().packets + receiver.counts().out_of_order,
              channel.counts().arrived);
    // Every fault has happened.
    EXPECT_GT(channel.counts().dropped, 0U);
    EXPECT_GT(channel.counts().reordered, 0U);
    EXPECT_GT(receiver.counts().out_of_order, 0U);
    EXPECT_GT(counts.checksum_failures, 0U);
    EXPECT_EQ(receiver.counts().refused, 0U);
}

}  // namespace
}  // namespace afferent
