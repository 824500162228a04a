#include "afferent/io/links/packet_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "afferent/io/wire/packetizer.hpp"

namespace afferent {
namespace {

constexpr Duration wait_of_a_packet = 2ms;
constexpr TimePoint end_of_packets = scene_start + 200ms;

// Busy enough for packets of several parts.
const PacketLayout busy_layout{.addresses = 9, .max_events = 8};

std::vector<Event> busy_events() {
    std::mt19937_64 random(4);
    std::vector<Event> events(600);
    for (Event& event : events)
        event = {scene_start + (random() % 1500) * 100us, static_cast<Address>(random() % 9)};
    std::sort(events.begin(), events.end());
    return events;
}

std::vector<proto::Envelope> busy_packets() {
    std::vector<proto::Envelope> packets;
    const auto keep = [&](const proto::Envelope& packet) { packets.push_back(packet); };
    Packetizer packetizer(busy_layout);
    const auto events = busy_events();
    packetizer.push(events);
    packetizer.finish(end_of_packets, keep);
    return packets;
}

// A receiver behind it, as a session has one.
class OrderedReceiving {
  public:
    explicit OrderedReceiving(Duration wait = wait_of_a_packet) : order_(wait) {}

    void arrive(const proto::Envelope& packet, Duration at) {
        now_ = MonotonicTime(at);
        if (!order_.hold(packet, receiver_, now_)) take(packet);
        wait_until(at);
    }
    void wait_until(Duration at) {
        now_ = MonotonicTime(at);
        while (const auto* next = order_.next(receiver_, now_)) take(next->packet);
    }
    void finish() {
        while (const auto* next = order_.next(receiver_, MonotonicTime::max())) take(next->packet);
    }
    std::optional<MonotonicTime> due() const { return order_.due(); }
    const PacketCounts& counts() const { return receiver_.counts(); }
    const std::vector<Event>& events() const { return events_; }

  private:
    void take(const proto::Envelope& packet) {
        if (const auto reception = receiver_.receive(packet))
            events_.insert(events_.end(), reception.value().events.begin(), reception.value().events.end());
    }

    PacketReceiver receiver_{busy_layout};
    PacketOrder order_;
    MonotonicTime now_;
    std::vector<Event> events_;
};

TEST(PacketOrder, CostsNothingWhereNothingIsMissing) {
    OrderedReceiving receiving;
    std::uint64_t packets = 0;
    for (const auto& packet : busy_packets()) {
        receiving.arrive(packet, 0ms);
        EXPECT_EQ(receiving.counts().packets, ++packets);
        EXPECT_FALSE(receiving.due());
    }
    EXPECT_EQ(receiving.events(), busy_events());
}

TEST(PacketOrder, LosesNothingThatIsOvertakenWithinItsTime) {
    const auto packets = busy_packets();
    ASSERT_TRUE(std::any_of(packets.begin(), packets.end(), [](const auto& one) { return one.part() > 1; }));
    std::mt19937_64 random(5);
    for (int round = 0; round < 50; ++round) {
        // Sent every 0.2 ms, and under way for up to 1.9 ms more than the fastest.
        std::vector<Duration> arrival(packets.size());
        for (std::size_t i = 0; i < packets.size(); ++i)
            arrival[i] = static_cast<std::int64_t>(i) * 200us + (random() % 1900) * 1us;
        std::vector<std::size_t> sequence(packets.size());
        std::iota(sequence.begin(), sequence.end(), 0U);
        std::stable_sort(sequence.begin(), sequence.end(),
                         [&](std::size_t a, std::size_t b) { return arrival[a] < arrival[b]; });
        OrderedReceiving receiving;
        for (const std::size_t i : sequence) receiving.arrive(packets.at(i), arrival[i]);
        EXPECT_FALSE(receiving.due());
        EXPECT_EQ(receiving.events(), busy_events());
        EXPECT_EQ(receiving.counts().gaps + receiving.counts().out_of_order, 0U);
        EXPECT_EQ(receiving.counts().lost_events, 0U);
    }
}

TEST(PacketOrder, WaitsNoLongerThanItsTime) {
    const auto packets = busy_packets();
    OrderedReceiving receiving;
    receiving.arrive(packets.at(0), 0ms);
    receiving.arrive(packets.at(2), 1ms);
    receiving.arrive(packets.at(3), 2ms);
    EXPECT_EQ(receiving.counts().packets, 1U);
    EXPECT_EQ(receiving.due(), MonotonicTime(3ms));
    receiving.wait_until(3ms - 1ns);
    EXPECT_EQ(receiving.counts().packets, 1U);
    // A packet that follows without a gap has nothing to wait for.
    receiving.wait_until(3ms);
    EXPECT_EQ(receiving.counts().packets, 3U);
    EXPECT_EQ(receiving.counts().gaps, 1U);
    EXPECT_FALSE(receiving.due());
    receiving.arrive(packets.at(1), 4ms);
    EXPECT_EQ(receiving.counts().out_of_order, 1U);
}

TEST(PacketOrder, CountsOneThatComesTwiceOnce) {
    const auto packets = busy_packets();
    OrderedReceiving receiving;
    for (const std::size_t i : {0U, 2U, 2U, 1U, 1U}) receiving.arrive(packets.at(i), 0ms);
    EXPECT_EQ(receiving.counts().packets, 3U);
    EXPECT_EQ(receiving.counts().out_of_order, 2U);
    EXPECT_FALSE(receiving.due());
}

TEST(PacketOrder, HoldsNoMoreThanItsMost) {
    const auto packets = busy_packets();
    ASSERT_GT(packets.size(), 33U);
    OrderedReceiving receiving;
    for (std::size_t i = 1; i < 32; ++i) receiving.arrive(packets.at(i), 0ms);
    EXPECT_EQ(receiving.counts().packets, 0U);
    receiving.arrive(packets.at(32), 0ms);
    EXPECT_EQ(receiving.counts().packets, 32U);
    EXPECT_EQ(receiving.counts().gaps, 1U);
}

TEST(PacketOrder, WithoutAnyTimeHoldsNothing) {
    const auto packets = busy_packets();
    OrderedReceiving receiving(Duration::zero());
    receiving.arrive(packets.at(1), 0ms);
    EXPECT_EQ(receiving.counts().packets, 1U);
}

TEST(PacketOrder, GivesUpEverythingAtTheEnd) {
    const auto packets = busy_packets();
    OrderedReceiving receiving;
    for (const std::size_t i : {4U, 2U, 6U}) receiving.arrive(packets.at(i), 0ms);
    receiving.finish();
    EXPECT_EQ(receiving.counts().packets, 3U);
    EXPECT_EQ(receiving.counts().out_of_order, 0U);
}

}  // namespace
}  // namespace afferent
