// What passes from a hand's link to its loop, and what is dropped on the way.
#include "afferent/nodes/grip_inbox.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/since_start.hpp"

namespace afferent {
namespace {

using InputKind = GripInput::Kind;

constexpr MonotonicTime now{std::chrono::hours(1)};
// Slots that packets leave free.
constexpr std::size_t reserved = 8;

Reception packet_of(Duration begin, Duration end) {
    Reception reception;
    reception.known = {at(begin), at(end)};
    return reception;
}

proto::Envelope numbered(std::uint32_t position) {
    proto::Envelope packet;
    packet.set_position(position);
    return packet;
}

std::vector<InputKind> taken(GripInbox& inbox) {
    std::vector<InputKind> kinds;
    for (; const GripInput* input = inbox.next(); inbox.pop()) kinds.push_back(input->kind);
    return kinds;
}

TEST(GripInbox, KeepsWhatAReceptionPointsTo) {
    GripInbox inbox(4, false);
    std::vector<Event> events{{at(1ms), 3}, {at(2ms), 5}};
    std::vector<Event> presumed{{at(7ms), 3}};
    Reception reception = packet_of(0ms, 5ms);
    reception.events = events;
    reception.presumed = presumed;
    reception.presumed_until = at(30ms);
    inbox.receive(reception, {}, now);
    inbox.packet(numbered(1));
    events.clear();
    presumed[0].address = 9;
    KeptReception taken;
    std::swap(taken, inbox.next()->reception);
    EXPECT_EQ(std::vector(taken.events.begin(), taken.events.end()),
              (std::vector<Event>{{at(1ms), 3}, {at(2ms), 5}}));
    EXPECT_EQ(std::vector(taken.presumed.begin(), taken.presumed.end()), (std::vector<Event>{{at(7ms), 3}}));
    EXPECT_EQ(taken.presumed_until, at(30ms));
}

TEST(GripInbox, PassesAPacketOnWithWhatItTold) {
    GripInbox inbox(4, true);
    inbox.receive(packet_of(0ms, 5ms), {}, now);
    EXPECT_EQ(inbox.next(), nullptr) << "the packet itself is still to come";
    inbox.packet(numbered(7));
    const GripInput* const input = inbox.next();
    ASSERT_TRUE(input);
    EXPECT_EQ(input->kind, InputKind::reception);
    EXPECT_EQ(input->reception.known, (TimeSpan{at(0ms), at(5ms)}));
    ASSERT_TRUE(input->has_message);
    EXPECT_EQ(input->message.position(), 7U);
}

// A gap that a bye reports comes without a packet.
TEST(GripInbox, PassesAReceptionWithoutAPacketOnBeforeTheNext) {
    GripInbox inbox(4, true);
    inbox.receive(packet_of(0ms, 5ms), {}, now);
    inbox.receive(packet_of(5ms, 10ms), {}, now);
    inbox.ended(now, std::nullopt);
    ASSERT_TRUE(inbox.next());
    EXPECT_EQ(inbox.next()->reception.known.end, at(5ms));
    EXPECT_FALSE(inbox.next()->has_message);
    inbox.pop();
    EXPECT_EQ(taken(inbox), (std::vector{InputKind::reception, InputKind::ended}));
}

TEST(GripInbox, PassesOnHowASessionEnded) {
    GripInbox inbox(4, true);
    proto::Bye bye;
    bye.set_text("the battery is empty");
    inbox.ended(now, bye);
    inbox.ended(now, std::nullopt);
    ASSERT_TRUE(inbox.next());
    ASSERT_TRUE(inbox.next()->has_message);
    EXPECT_EQ(inbox.next()->message.bye().text(), "the battery is empty");
    inbox.pop();
    ASSERT_TRUE(inbox.next());
    EXPECT_FALSE(inbox.next()->has_message);
}

// The hand is frozen and made safe by these times.
TEST(GripInbox, SaysWhenEachInputCame) {
    GripInbox inbox(8, true);
    inbox.restart(now + 1ms);
    inbox.steer(now + 2ms, 3ms);
    inbox.acknowledged(now + 4ms);
    inbox.receive(packet_of(0ms, 5ms), {}, now + 5ms);
    inbox.packet(numbered(1));
    inbox.ended(now + 6ms, std::nullopt);
    std::vector<Duration> since;
    for (; const GripInput* input = inbox.next(); inbox.pop()) since.push_back(input->at - now);
    EXPECT_EQ(since, (std::vector<Duration>{1ms, 2ms, 4ms, 5ms, 6ms}));
}

TEST(GripInbox, TellsANewSessionNothingOfWhatTheOneBeforeLost) {
    GripInbox inbox(1, false);
    inbox.receive(packet_of(0ms, 5ms), {}, now);
    inbox.packet({});
    inbox.receive(packet_of(5ms, 10ms), {}, now);
    EXPECT_EQ(inbox.dropped(), 1U);
    inbox.ended(now, std::nullopt);
    EXPECT_EQ(taken(inbox), (std::vector{InputKind::reception, InputKind::ended}));
    inbox.receive(packet_of(100ms, 105ms), {}, now);
    inbox.packet({});
    ASSERT_TRUE(inbox.next());
    EXPECT_EQ(inbox.next()->reception.gap, std::nullopt);
}

TEST(GripInbox, PassesARefusedPacketOnWhereItIsRecorded) {
    for (const bool keeps_messages : {true, false}) {
        GripInbox inbox(4, keeps_messages);
        inbox.packet(numbered(1));
        EXPECT_EQ(taken(inbox), keeps_messages ? std::vector{InputKind::refused} : std::vector<InputKind>{});
    }
}

TEST(GripInbox, DropsAPacketThatFindsNoRoomAndAllOfIt) {
    GripInbox inbox(1, true);
    inbox.receive(packet_of(0ms, 5ms), {}, now);
    inbox.packet(numbered(1));
    inbox.receive(packet_of(5ms, 10ms), {}, now);
    EXPECT_EQ(inbox.dropped(), 1U);
    inbox.pop();
    inbox.packet(numbered(2));
    EXPECT_EQ(inbox.next(), nullptr) << "there is room by now, but what it told is gone";
    inbox.receive(packet_of(10ms, 15ms), {}, now);
    inbox.packet(numbered(3));
    ASSERT_TRUE(inbox.next());
    EXPECT_EQ(inbox.next()->reception.gap, (TimeSpan{at(5ms), at(10ms)}));
    EXPECT_EQ(inbox.next()->message.position(), 3U);
}

TEST(GripInbox, TakesPacketsThatFoundNoRoomForAGap) {
    GripInbox inbox(4, false);
    const auto span = [](int k) { return TimeSpan{scene_start + k * 5ms, scene_start + (k + 1) * 5ms}; };
    const auto receive = [&](int k) {
        inbox.receive(packet_of(k * 5ms, (k + 1) * 5ms), {}, now);
        inbox.packet({});
    };
    const auto take = [&] {
        GripInput* const next = inbox.next();
        if (!next) throw std::runtime_error("there is no input");
        GripInput taken;
        std::swap(taken, *next);
        inbox.pop();
        return taken;
    };
    for (int k = 0; k < 10; ++k) receive(k);
    EXPECT_EQ(inbox.dropped(), 6U);
    // The beginning and the end of a session pass all the same.
    inbox.acknowledged(now);
    for (int k = 0; k < 4; ++k) {
        const GripInput taken = take();
        EXPECT_EQ(taken.reception.known, span(k));
        EXPECT_EQ(taken.reception.gap, std::nullopt);
    }
    EXPECT_EQ(take().kind, InputKind::acknowledged);
    receive(10);
    EXPECT_EQ(take().reception.gap, (TimeSpan{span(4).begin, span(9).end}));
    receive(11);
    EXPECT_EQ(take().reception.gap, std::nullopt) << "it is told once";
    EXPECT_EQ(inbox.next(), nullptr);
}

TEST(GripInbox, NeverLosesASessionsBeginAndEnd) {
    GripInbox inbox(4, false);
    for (int k = 0; k < 20; ++k) inbox.opened(now, {});
    inbox.stop();
    int taken = 0;
    bool stopped = false;
    for (int i = 0; i < 3; ++i, inbox.flush())
        for (; const GripInput* input = inbox.next(); inbox.pop(), ++taken)
            stopped = input->kind == InputKind::stop;
    EXPECT_EQ(taken, 21);
    EXPECT_TRUE(stopped) << "and keeps their order";
}

TEST(GripInbox, LetsNoPacketOvertakeWhatWaits) {
    constexpr std::size_t slots = 4 + reserved;
    GripInbox inbox(4, false);
    for (std::size_t i = 0; i < slots + 2; ++i) inbox.acknowledged(now);
    inbox.ended(now, std::nullopt);
    for (std::size_t i = 0; i + 1 < slots; ++i) inbox.pop();
    // Three wait for room. A packet does not overtake them, and leaves eight slots free.
    inbox.receive(packet_of(0ms, 5ms), {}, now);
    inbox.packet({});
    EXPECT_EQ(inbox.dropped(), 1U);
    EXPECT_EQ(taken(inbox), (std::vector{InputKind::acknowledged, InputKind::acknowledged,
                                         InputKind::acknowledged, InputKind::ended}));
    inbox.receive(packet_of(5ms, 10ms), {}, now);
    inbox.packet({});
    EXPECT_EQ(inbox.dropped(), 1U);
    EXPECT_EQ(taken(inbox), std::vector{InputKind::reception});
}

TEST(GripInbox, TakesAPacketBehindWhatWaitsWhereAllOfItFits) {
    constexpr std::size_t slots = 4 + reserved;
    GripInbox inbox(4, false);
    for (std::size_t i = 0; i < slots + 2; ++i) inbox.acknowledged(now);
    for (std::size_t i = 0; i < slots; ++i) inbox.pop();
    inbox.receive(packet_of(0ms, 5ms), {}, now);
    inbox.packet({});
    EXPECT_EQ(taken(inbox),
              (std::vector{InputKind::acknowledged, InputKind::acknowledged, InputKind::reception}));
}

}  // namespace
}  // namespace afferent
