// Packets that say only what the other end did not foresee.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

PacketLayout foreseen_layout(Duration tolerance = 0us) {
    return {.addresses = 9, .encoding = Encoding::predicted, .tolerance = tolerance, .neurons = {{9, {}}}};
}

// Afferents that fire at rates that drift, from `begin` on.
std::vector<Event> drifting_events(TimePoint begin, TimePoint end, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<Event> events;
    for (Address address = 0; address < 9; ++address) {
        double interval_ms = 15 + 2.0 * address;
        for (TimePoint time = begin + Duration(address * 1ms); time < end;) {
            events.push_back({time, address});
            interval_ms *= 1 + 0.01 * (static_cast<double>(random() % 1001) - 500) / 500;
            time += Duration(static_cast<std::int64_t>(interval_ms * 1e6));
        }
    }
    std::sort(events.begin(), events.end());
    return events;
}

struct ForeseenStream {
    std::vector<proto::Envelope> packets;
    std::uint64_t events = 0;
    std::size_t bytes = 0;
};

ForeseenStream foreseen_stream(const PacketLayout& layout, const std::vector<Event>& events, TimePoint end) {
    Packetizer packetizer(layout);
    ForeseenStream stream;
    FrameWriter writer;
    packetizer.push(events);
    packetizer.finish(end, [&](const proto::Envelope& packet) {
        stream.packets.push_back(packet);
        stream.bytes += writer.stream_frame(packet).size();
    });
    stream.events = packetizer.events();
    return stream;
}

struct ForeseenEvents {
    std::vector<Event> events;
    std::vector<TimeSpan> gaps;
    Duration known{};
};

void take_foreseen(ForeseenEvents& taken, const Reception& reception) {
    taken.events.insert(taken.events.end(), reception.events.begin(), reception.events.end());
    taken.known += reception.known.end - reception.known.begin;
    if (reception.gap) taken.gaps.push_back(*reception.gap);
    for (const Event& event : reception.events) {
        EXPECT_GE(event.time, reception.known.begin);
        EXPECT_LT(event.time, reception.known.end);
    }
}

ForeseenEvents take_all(PacketReceiver& receiver, const std::vector<proto::Envelope>& packets) {
    ForeseenEvents taken;
    for (const proto::Envelope& packet : packets) {
        const Result<Reception> reception = receiver.receive(packet);
        EXPECT_TRUE(reception) << reception.error().text;
        if (reception) take_foreseen(taken, reception.value());
    }
    return taken;
}

std::vector<Event> at_ticks(std::vector<Event> events, Duration tick = 100us) {
    for (Event& event : events) event.time -= (event.time - scene_start) % tick;
    std::sort(events.begin(), events.end());
    return events;
}

TEST(PredictedPackets, BringEveryEventToItsTickInFewerBytes) {
    const PacketLayout layout = foreseen_layout();
    const std::vector<Event> events = drifting_events(at(1s), at(9s), 1);
    const ForeseenStream stream = foreseen_stream(layout, events, at(10s));
    PacketReceiver receiver(layout);
    const ForeseenEvents taken = take_all(receiver, stream.packets);
    EXPECT_EQ(taken.events, at_ticks(events));
    EXPECT_TRUE(taken.gaps.empty());
    EXPECT_EQ(taken.known, 10s);
    EXPECT_EQ(stream.events, events.size());
    EXPECT_EQ(receiver.counts().events, events.size());
    PacketLayout independent = layout;
    independent.encoding = Encoding::rice;
    EXPECT_LT(stream.bytes, foreseen_stream(independent, events, at(10s)).bytes);
}

TEST(PredictedPackets, AreSilentWhereSpikesComeWithinTheTolerance) {
    const PacketLayout layout = foreseen_layout(1ms);
    const std::vector<Event> events = drifting_events(at(1s), at(9s), 2);
    const ForeseenStream stream = foreseen_stream(layout, events, at(10s));
    PacketReceiver receiver(layout);
    const ForeseenEvents taken = take_all(receiver, stream.packets);
    ASSERT_EQ(taken.events.size(), events.size());
    std::vector<std::vector<Event>> fired(9);
    std::vector<std::vector<Event>> told(9);
    for (const Event& event : events) fired[event.address].push_back(event);
    for (const Event& event : taken.events) told[event.address].push_back(event);
    for (Address address = 0; address < 9; ++address) {
        std::sort(told[address].begin(), told[address].end());
        ASSERT_EQ(told[address].size(), fired[address].size());
        for (std::size_t i = 0; i < told[address].size(); ++i)
            EXPECT_LE(std::chrono::abs(told[address][i].time - fired[address][i].time), 1ms + layout.tick);
    }
    EXPECT_TRUE(std::is_sorted(taken.events.begin(), taken.events.end()));
    const std::size_t exact = foreseen_stream(foreseen_layout(), events, at(10s)).packets.size();
    EXPECT_LT(stream.packets.size(), exact * 2 / 3);
    EXPECT_GE(stream.packets.size(), 400U) << "heartbeats come as ever";
}

TEST(PredictedPackets, TellOfASurpriseAtOnce) {
    // All that is told is in the packet of its own span, as without prediction.
    const PacketLayout layout = foreseen_layout(1ms);
    std::vector<Event> events = drifting_events(at(1s), at(3s), 3);
    const Event touch{at(2s + 502ms + 300us), 4};
    std::erase_if(events, [&](const Event& event) { return event.address == 4; });
    events.push_back(touch);
    std::sort(events.begin(), events.end());
    PacketReceiver receiver(layout);
    Packetizer packetizer(layout);
    packetizer.push(events);
    std::optional<TimePoint> told;
    for (TimePoint deadline = at(5ms); deadline <= at(3s); deadline += 5ms)
        packetizer.close(deadline, [&](const proto::Envelope& packet) {
            const auto reception = receiver.receive(packet);
            ASSERT_TRUE(reception);
            for (const Event& event : reception.value().events)
                if (event.address == 4) told = deadline;
        });
    EXPECT_EQ(told, at(2s + 505ms));
}

TEST(PredictedPackets, BeginAnewAfterOneThatWasDropped) {
    for (const Duration tolerance : {Duration(0us), Duration(500us)}) {
        const PacketLayout layout = foreseen_layout(tolerance);
        const std::vector<Event> events = drifting_events(at(0s), at(4s), 4);
        Packetizer packetizer(layout);
        PacketReceiver receiver(layout);
        ForeseenEvents taken;
        packetizer.push(events);
        std::mt19937_64 random(5);
        std::uint64_t dropped = 0;
        const auto sink = [&](const proto::Envelope& packet) {
            if (random() % 50 == 0) {
                ++dropped;
                return packetizer.announce();
            }
            const auto reception = receiver.receive(packet);
            ASSERT_TRUE(reception) << reception.error().text;
            take_foreseen(taken, reception.value());
        };
        packetizer.finish(at(4s), sink);
        ASSERT_GT(dropped, 2U);
        EXPECT_GE(taken.gaps.size(), dropped / 2);
        // What is outside of the gaps is complete, and what is inside is counted.
        const auto in_gap = [&](const Event& event) {
            return std::any_of(taken.gaps.begin(), taken.gaps.end(), [&](const TimeSpan& gap) {
                return event.time >= gap.begin - 2 * tolerance && event.time < gap.end + 2 * tolerance;
            });
        };
        std::vector<Event> sure = tolerance == 0us ? at_ticks(events) : events;
        std::erase_if(sure, in_gap);
        std::vector<Event> told = taken.events;
        std::erase_if(told, in_gap);
        EXPECT_EQ(told.size(), sure.size());
        if (tolerance == 0us) {
            EXPECT_EQ(told, sure);
        }
        EXPECT_EQ(receiver.counted_events(), events.size());
        EXPECT_EQ(receiver.counts().refused, 0U);
    }
}

TEST(PredictedPackets, ThatReferToWhatHasNotComeTellOfAGap) {
    const PacketLayout layout = foreseen_layout();
    const ForeseenStream stream = foreseen_stream(layout, drifting_events(at(0s), at(2s), 6), at(2s));
    // A receiver that joins in the middle, and one that resumes there, foresee nothing.
    for (const bool resumes : {false, true}) {
        PacketReceiver receiver(layout);
        std::size_t from = 40;
        if (resumes) {
            PacketReceiver before(layout);
            for (std::size_t i = 0; i < from; ++i) ASSERT_TRUE(before.receive(stream.packets[i]));
            receiver.resume(before.position(), before.counted_events());
        }
        for (std::size_t i = from; i < stream.packets.size(); ++i) {
            const auto reception = receiver.receive(stream.packets[i]);
            ASSERT_TRUE(reception) << reception.error().text;
            EXPECT_FALSE(reception.value().measured()) << "no sign of life";
            EXPECT_TRUE(reception.value().events.empty());
            EXPECT_TRUE(reception.value().gap);
        }
        EXPECT_EQ(receiver.end(), at(2s));
        EXPECT_EQ(receiver.counts().events, 0U);
        EXPECT_GT(receiver.counts().unknown, 1500ms);
    }
}

TEST(PredictedPackets, OfAnotherStateAreFoundAtTheNextHeartbeat) {
    const PacketLayout layout = foreseen_layout();
    const ForeseenStream stream = foreseen_stream(layout, drifting_events(at(0s), at(1s), 7), at(1s + 100ms));
    PacketReceiver receiver(layout);
    bool found = false;
    for (proto::Envelope packet : stream.packets) {
        if (packet.has_check()) packet.set_check(packet.check() ^ 1);
        const auto reception = receiver.receive(packet);
        if (packet.has_check()) {
            ASSERT_FALSE(reception);
            EXPECT_NE(reception.error().text.find("foreseen otherwise"), std::string::npos);
            found = true;
        } else {
            ASSERT_TRUE(reception);
            EXPECT_EQ(reception.value().measured(), !found) << "nothing is used after it";
        }
    }
    EXPECT_TRUE(found);
    EXPECT_EQ(receiver.counts().refused, 1U);
}

TEST(PredictedPackets, GoOnInFurtherParts) {
    PacketLayout layout = foreseen_layout(500us);
    layout.max_events = 7;
    std::mt19937_64 random(8);
    std::vector<Event> events;
    for (int volley = 0; volley < 60; ++volley)
        for (int i = 0; i < 30; ++i)
            events.push_back({at(Duration(volley * 40ms) + Duration(random() % 4'000'000)),
                              static_cast<Address>(random() % 9)});
    std::sort(events.begin(), events.end());
    const ForeseenStream stream = foreseen_stream(layout, events, at(3s));
    PacketReceiver receiver(layout);
    const ForeseenEvents taken = take_all(receiver, stream.packets);
    EXPECT_EQ(taken.events.size(), events.size());
    EXPECT_EQ(at_ticks(taken.events), taken.events) << "sorted, over all parts";
    EXPECT_TRUE(std::any_of(stream.packets.begin(), stream.packets.end(),
                            [](const proto::Envelope& packet) { return packet.part() > 2; }));
    // Without its first part a packet is not used.
    PacketReceiver without(layout);
    bool lost = false;
    for (const proto::Envelope& packet : stream.packets) {
        if (!lost && packet.more() && packet.part() == 0) {
            lost = true;
            continue;
        }
        const auto reception = without.receive(packet);
        ASSERT_TRUE(reception) << reception.error().text;
        if (lost) {
            EXPECT_TRUE(reception.value().events.empty());
        }
    }
}

TEST(PredictedPackets, TakeNoMoreAtRestThanOthers) {
    PacketLayout independent = foreseen_layout();
    independent.encoding = Encoding::rice;
    EXPECT_EQ(foreseen_stream(foreseen_layout(1ms), {}, at(10s)).bytes,
              foreseen_stream(independent, {}, at(10s)).bytes);
}

}  // namespace
}  // namespace afferent
