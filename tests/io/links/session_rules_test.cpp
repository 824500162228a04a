// How the two ends of a session treat messages, in virtual time: the peer is the test.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "afferent/io/links/session.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "tests/io/links/hello_message.hpp"

namespace afferent {
namespace {

constexpr MonotonicTime session_start{std::chrono::hours(1)};

class ScriptedLink final : public Link {
  public:
    // Outlives the link.
    struct Wire {
        LinkCallbacks callbacks;
        std::vector<proto::Envelope> sent;
        bool closed = false;

        template <class Of>
        std::vector<proto::Envelope> all(Of of) const {
            std::vector<proto::Envelope> found;
            std::copy_if(sent.begin(), sent.end(), std::back_inserter(found),
                         [of](const auto& message) { return (message.*of)(); });
            return found;
        }
        const proto::Envelope& last_sent() const { return sent.at(sent.size() - 1); }
    };

    ScriptedLink(Wire& wire, bool ordered) : wire_(wire), ordered_(ordered) {}
    void start(LinkCallbacks callbacks) override { wire_.callbacks = std::move(callbacks); }
    bool send(const proto::Envelope& message) override {
        wire_.sent.push_back(message);
        return true;
    }
    void close() override { wire_.closed = true; }
    std::size_t queued_bytes() const override { return 0; }
    bool ordered() const override { return ordered_; }
    const LinkCounts& counts() const override { return counts_; }

  private:
    Wire& wire_;
    bool ordered_;
    LinkCounts counts_;
};

proto::Hello hello_with_a_nonce() {
    proto::Hello hello = hello_of_nine();
    hello.set_stale_ms(50);
    hello.set_nonce(7);
    return hello;
}

proto::Envelope bye() {
    proto::Envelope message;
    message.mutable_bye();
    return message;
}

class TestedHand final : public HandClient {
  public:
    explicit TestedHand(bool ordered = true)
        : session(std::make_unique<ScriptedLink>(wire, ordered), hello_with_a_nonce(), *this, {},
                  [this] { return now; }) {
        session.start();
    }
    void welcomed(const proto::Hello&) override { ++welcomes; }
    void received(const Reception& reception) override { receptions.push_back(reception); }
    std::optional<TimePoint> scene_time() const override { return ours; }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd& end) override { ends.push_back(end); }

    void hear(const proto::Envelope& message) { wire.callbacks.message(message); }
    void hear_hello() {
        proto::Envelope hello;
        *hello.mutable_hello() = hello_with_a_nonce();
        hear(hello);
    }
    void hear_echo(std::uint32_t number, TimePoint shown) {
        proto::Envelope echo;
        echo.mutable_echo()->set_number(number);
        echo.mutable_echo()->set_time_ns((shown - scene_start).count());
        hear(echo);
    }
    // A silent packet that ends then.
    void hear_packet(TimePoint end) {
        packetizer.close(end - 5ms, [](const auto&) {});
        packetizer.push(std::vector{Event{end - 5ms, 0}});
        packetizer.close(end, [this](const proto::Envelope& packet) { hear(packet); });
    }
    // 0 before the first.
    std::uint32_t last_probe() const {
        const auto probes = wire.all(&proto::Envelope::has_probe);
        return probes.empty() ? 0 : probes.back().probe().number();
    }

    MonotonicTime now = session_start;
    ScriptedLink::Wire wire;
    Packetizer packetizer{PacketLayout{.addresses = 9}};
    std::optional<TimePoint> ours;
    int welcomes = 0;
    std::vector<Reception> receptions;
    std::vector<SessionEnd> ends;
    HandSession session;
};

TEST(HandSession, RefusesAByeBeforeAnyHello) {
    TestedHand stream;
    stream.hear(bye());
    ASSERT_EQ(stream.ends.size(), 1U);
    EXPECT_FALSE(stream.ends.at(0).complete);
    EXPECT_FALSE(stream.ends.at(0).bye.has_value());
    EXPECT_EQ(stream.ends.at(0).reason, "the peer says bye before there is a session");
    TestedHand datagrams(false);
    datagrams.hear(bye());
    EXPECT_TRUE(datagrams.ends.empty()) << "it may belong to a session before";
    datagrams.hear_hello();
    EXPECT_EQ(datagrams.welcomes, 1);
}

// A datagram may come twice, and its answer may have been lost.
TEST(HandSession, RefusesASecondHelloOnAStreamAlone) {
    TestedHand stream;
    stream.hear_hello();
    stream.hear_hello();
    EXPECT_EQ(stream.session.refused_messages(), 1U);
    EXPECT_EQ(stream.wire.all(&proto::Envelope::has_answer).size(), 1U);
    TestedHand datagrams(false);
    datagrams.hear_hello();
    datagrams.hear_hello();
    EXPECT_EQ(datagrams.session.refused_messages(), 0U);
    EXPECT_EQ(datagrams.wire.all(&proto::Envelope::has_answer).size(), 2U);
}

TEST(HandSession, AsksForTheClockAtOnceAndThenAFewTimesASecond) {
    TestedHand hand;
    hand.hear_hello();
    EXPECT_EQ(hand.last_probe(), 1U);
    for (; hand.now < session_start + 100ms; hand.now += 10ms) hand.session.poll();
    EXPECT_EQ(hand.last_probe(), 5U) << "every 20 ms while the clock is unknown";
    hand.hear_echo(5, scene_start + 40ms);
    EXPECT_TRUE(hand.session.peer_clock().known());
    const std::uint32_t before = hand.last_probe();
    for (; hand.now < session_start + 1100ms; hand.now += 10ms) hand.session.poll();
    EXPECT_EQ(hand.last_probe(), before + 4);
}

TEST(HandSession, JudgesAPacketByItsAgeOnTheCoprocessorsClock) {
    TestedHand hand;
    hand.hear_hello();
    hand.hear_packet(scene_start + 20ms);
    ASSERT_EQ(hand.receptions.size(), 1U);
    EXPECT_TRUE(hand.receptions[0].stale) << "nobody knows how old it is";
    EXPECT_EQ(hand.receptions[0].age, Duration::max());
    // One round trip of 10 ms: the coprocessor showed 1000 ms in the middle of it.
    hand.now += 10ms;
    hand.hear_echo(1, scene_start + 1000ms);
    const auto age_of = [&](Duration stamp) {
        hand.hear_packet(scene_start + stamp);
        return hand.receptions.back();
    };
    EXPECT_TRUE(age_of(950ms).stale);
    EXPECT_NEAR(Milliseconds(hand.receptions.back().age).count(), 55, 0.1);
    EXPECT_FALSE(age_of(960ms).stale);
    EXPECT_NEAR(Milliseconds(hand.receptions.back().age).count(), 45, 0.1);
    EXPECT_EQ(hand.session.receiver_counts().stale, 2U);
    // Where the samples are ours, the age of a packet begins with them.
    hand.ours = scene_start + 1040ms;
    EXPECT_TRUE(age_of(980ms).stale);
    EXPECT_EQ(hand.receptions.back().age, 60ms);
}

TEST(HandSession, RefusesAndCountsAPacketFromAheadOfItsTime) {
    TestedHand hand;
    hand.hear_hello();
    hand.now += 1ms;
    hand.hear_echo(1, scene_start + 1s);
    Packetizer other(PacketLayout{.addresses = 9});
    other.begin_at(scene_start + 2995ms);
    other.push(std::vector{Event{scene_start + 2996ms, 0}});
    other.close(scene_start + 3s, [&](const proto::Envelope& packet) { hand.hear(packet); });
    EXPECT_EQ(hand.session.refused_messages(), 1U);
    EXPECT_NE(hand.session.last_refusal().find("ms later than can be"), std::string::npos);
    EXPECT_TRUE(hand.receptions.empty());
    hand.hear_packet(scene_start + 1s);
    ASSERT_EQ(hand.receptions.size(), 1U) << "it has left no trace";
    EXPECT_FALSE(hand.receptions[0].stale);
    EXPECT_TRUE(hand.ends.empty());
}

// It waits for one that it has overtaken, until the session ends.
TEST(HandSession, CountsAPacketThatItRefusesAsItEnds) {
    TestedHand hand(false);
    hand.hear_hello();
    hand.now += 1ms;
    hand.hear_echo(1, scene_start + 1s);
    hand.packetizer.begin_at(scene_start + 2990ms);
    hand.hear_packet(scene_start + 3s);
    EXPECT_EQ(hand.session.refused_messages(), 0U) << "it waits";
    hand.hear(bye());
    EXPECT_EQ(hand.session.refused_messages(), 1U);
    EXPECT_TRUE(hand.receptions.empty());
}

TEST(HandSession, AllowsAPacketToBeAheadByWhatIsNotKnownOfTheClock) {
    TestedHand hand;
    hand.hear_hello();
    hand.now += 100ms;
    hand.hear_echo(1, scene_start + 1s);
    // The echo was sent at some time of the round trip: it is 1050 ms there, give or take 50. Besides, a
    // packet of 5 ms may be ahead by 100 ms.
    hand.hear_packet(scene_start + 1050ms + 50ms + 5ms + 100ms);
    EXPECT_EQ(hand.receptions.size(), 1U) << hand.session.last_refusal();
    hand.hear_packet(scene_start + 1210ms);
    EXPECT_EQ(hand.receptions.size(), 1U);
    EXPECT_EQ(hand.session.refused_messages(), 1U);
}

TEST(HandSession, TakesOneEchoOfEachProbeAndNoneOfOthers) {
    TestedHand hand;
    hand.hear_hello();
    for (const std::uint32_t number : {0U, 2U, 99U}) hand.hear_echo(number, scene_start);
    EXPECT_EQ(hand.session.refused_messages(), 3U);
    EXPECT_FALSE(hand.session.peer_clock().known());
    hand.hear_echo(1, scene_start);
    EXPECT_TRUE(hand.session.peer_clock().known());
    hand.hear_echo(1, scene_start);
    EXPECT_EQ(hand.session.refused_messages(), 4U);
}

TEST(HandSession, TakesEchoesOfItsLastSixteenProbesAlone) {
    TestedHand hand;
    hand.hear_hello();
    while (hand.last_probe() < 17) {
        hand.now += 10ms;
        hand.session.poll();
    }
    hand.hear_echo(1, scene_start + 10ms);
    EXPECT_FALSE(hand.session.peer_clock().known());
    hand.hear_echo(2, scene_start + 10ms);
    EXPECT_TRUE(hand.session.peer_clock().known());
}

// A coprocessor that was held up answers everything at once.
TEST(HandSession, DoesNotHoldEchoesThatComeTooLateAgainstThePeer) {
    TestedHand hand;
    hand.hear_hello();
    for (; hand.now < session_start + 800ms; hand.now += 10ms) hand.session.poll();
    const std::uint32_t last = hand.last_probe();
    ASSERT_GT(last, 30U);
    for (std::uint32_t number = 1; number <= last; ++number) hand.hear_echo(number, scene_start + 790ms);
    EXPECT_EQ(hand.session.refused_messages(), 0U);
    EXPECT_TRUE(hand.ends.empty());
    EXPECT_TRUE(hand.session.peer_clock().known());
}

TEST(HandSession, TellsWhatItKnowsOfTheClock) {
    TestedHand hand;
    hand.hear_hello();
    hand.session.send_status({});
    EXPECT_FALSE(hand.wire.last_sent().status().has_round_trip_us());
    hand.now += 4ms;
    hand.hear_echo(1, scene_start + 100ms);
    hand.ours = scene_start + 80ms;
    hand.session.send_status({});
    const proto::Status& status = hand.wire.last_sent().status();
    EXPECT_EQ(status.round_trip_us(), 4000U);
    EXPECT_NEAR(static_cast<double>(status.ahead_us()), 22'000, 10);
    hand.now += 300ms;
    hand.session.poll();
    EXPECT_NEAR(static_cast<double>(hand.wire.last_sent().probe().ahead_ns()), 322e6, 1e6);
}

TEST(HandSession, MakesPacketsWithoutSamplesAGap) {
    TestedHand hand;
    hand.hear_hello();
    hand.hear_echo(1, scene_start + 10ms);
    hand.packetizer.push(std::vector{Event{scene_start + 6ms, 0}});
    hand.packetizer.close(scene_start + 10ms, [&](proto::Envelope packet) {
        packet.set_no_samples_since_ns(1'000'000);
        hand.hear(packet);
    });
    ASSERT_EQ(hand.receptions.size(), 1U);
    const Reception& told = hand.receptions[0];
    EXPECT_TRUE(told.no_samples);
    EXPECT_FALSE(told.usable());
    EXPECT_EQ(told.gap, (TimeSpan{scene_start, scene_start + 10ms}));
    EXPECT_EQ(told.known.begin, told.known.end);
    EXPECT_TRUE(told.events.empty());
    EXPECT_EQ(hand.session.receiver_counts().stale, 0U);
}

class TestedCoprocessor final : public CoprocessorClient {
  public:
    explicit TestedCoprocessor(bool ordered = true)
        : session(std::make_unique<ScriptedLink>(wire, ordered), hello_with_a_nonce(), *this, {},
                  [] { return session_start; }) {
        session.start();
        proto::Envelope answer;
        answer.mutable_answer()->set_welcome(true);
        answer.mutable_answer()->set_nonce(hello_with_a_nonce().nonce());
        wire.callbacks.message(answer);
    }
    void welcomed() override {}
    std::optional<TimePoint> scene_time() const override { return shown; }
    void ahead(Duration ahead) override { told_ahead = ahead; }
    void samples(const proto::Samples&) override { ++scans; }
    proto::Bye answer_bye(const proto::Bye&) override { return {}; }
    void ended(const SessionEnd& end) override { ends.push_back(end); }

    ScriptedLink::Wire wire;
    std::optional<TimePoint> shown;
    std::optional<Duration> told_ahead;
    int scans = 0;
    std::vector<SessionEnd> ends;
    CoprocessorSession session;
};

TEST(CoprocessorSession, AnswersAProbeOnceItsClockRuns) {
    TestedCoprocessor coprocessor;
    proto::Envelope probe;
    probe.mutable_probe()->set_number(3);
    coprocessor.wire.callbacks.message(probe);
    EXPECT_TRUE(coprocessor.wire.all(&proto::Envelope::has_echo).empty());
    coprocessor.shown = scene_start + 2s;
    probe.mutable_probe()->set_ahead_ns(-5);
    coprocessor.wire.callbacks.message(probe);
    const auto echoes = coprocessor.wire.all(&proto::Envelope::has_echo);
    ASSERT_EQ(echoes.size(), 1U);
    EXPECT_EQ(echoes[0].echo().number(), 3U);
    EXPECT_EQ(echoes[0].echo().time_ns(), Duration(2s).count());
    EXPECT_EQ(coprocessor.told_ahead, Duration(-5));
    probe.mutable_probe()->set_ahead_ns(std::numeric_limits<std::int64_t>::min());
    coprocessor.wire.callbacks.message(probe);
    EXPECT_EQ(coprocessor.session.refused_messages(), 1U);
    EXPECT_EQ(coprocessor.told_ahead, Duration(-5));
}

TEST(CoprocessorSession, TakesNoForceThatIsNone) {
    for (const double force_n : {1.5, std::nan(""), std::numeric_limits<double>::infinity()}) {
        TestedCoprocessor coprocessor;
        proto::Envelope samples;
        samples.mutable_samples()->add_force_n(0.5);
        samples.mutable_samples()->add_force_n(force_n);
        coprocessor.wire.callbacks.message(samples);
        EXPECT_EQ(coprocessor.scans, std::isfinite(force_n) ? 1 : 0) << force_n;
        EXPECT_EQ(coprocessor.session.refused_messages(), std::isfinite(force_n) ? 0U : 1U) << force_n;
    }
}

TEST(CoprocessorSession, ThatWasOpenDoesNotEndAsUnanswered) {
    TestedCoprocessor broken_off, cut_off, dismissed;
    broken_off.session.break_off("for a reason");
    cut_off.wire.callbacks.closed({Error::Kind::closed, "unplugged"});
    dismissed.wire.callbacks.message(bye());
    for (const TestedCoprocessor* coprocessor : {&broken_off, &cut_off, &dismissed}) {
        ASSERT_EQ(coprocessor->ends.size(), 1U);
        EXPECT_FALSE(coprocessor->ends[0].unanswered) << coprocessor->ends[0].reason;
    }
}

TEST(CoprocessorSession, ThatBreaksOffSaysWhyAndWaitsForNobody) {
    for (const bool ordered : {true, false}) {
        TestedCoprocessor coprocessor(ordered);
        coprocessor.session.break_off("for a reason");
        EXPECT_EQ(coprocessor.wire.all(&proto::Envelope::has_bye).size(), ordered ? 1U : 3U);
        EXPECT_EQ(coprocessor.wire.last_sent().bye().text(), "for a reason");
        EXPECT_TRUE(coprocessor.wire.closed);
        ASSERT_EQ(coprocessor.ends.size(), 1U);
        EXPECT_FALSE(coprocessor.ends.at(0).complete);
    }
}

}  // namespace
}  // namespace afferent
