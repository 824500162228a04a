// A coprocessor on a link: without a hand, with one, with several one after another. In virtual time.
#include "afferent/nodes/coprocessor_node.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "afferent/io/files/recording.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run_summary.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

// A hand that welcomes everyone, and then sends what it is told to.
class RawHand {
  public:
    explicit RawHand(MemoryLinks& links) : listener_(links.listener()) {
        listener_->start([this](std::unique_ptr<Link> link) {
            link_ = std::move(link);
            link_->start({.message =
                              [this](const proto::Envelope& message) {
                                  if (message.has_echo())
                                      last_echo = scene_start + Duration(message.echo().time_ns());
                                  if (!message.has_hello()) return;
                                  ++hellos;
                                  proto::Envelope answer;
                                  answer.mutable_answer()->set_nonce(message.hello().nonce());
                                  answer.mutable_answer()->set_welcome(true);
                                  link_->send(answer);
                              },
                          .bad_frame = [](const Error&) {},
                          .closed = [](const Error&) {}});
        });
    }
    void say(const proto::Envelope& message) {
        if (!link_) throw std::runtime_error("nobody has connected");
        link_->send(message);
    }
    // Asks for the clock, and says how far it is ahead, if that is known.
    void probe(std::optional<Duration> ahead = {}) {
        proto::Envelope message;
        message.mutable_probe()->set_number(++probes_);
        if (ahead) message.mutable_probe()->set_ahead_ns(ahead->count());
        say(message);
    }
    int hellos = 0;
    std::optional<TimePoint> last_echo;  // the time that it told

  private:
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<Link> link_;
    std::uint32_t probes_ = 0;
};

TEST(CoprocessorNode, GivesUpOnAHandThatIsNotThere) {
    TwoNodes two(press());
    two.start_coprocessor();
    two.run_for(4900ms);
    EXPECT_FALSE(two.coprocessor.ended);
    two.run_for(200ms);
    EXPECT_TRUE(two.coprocessor.ended);
    EXPECT_EQ(two.coprocessor.node->failure(), "nobody listens");
    EXPECT_EQ(two.coprocessor.node->report().sessions, 0U);
}

TEST(CoprocessorNode, WaitsForAHandThatComesLater) {
    TwoNodes two(press());
    two.start_coprocessor();
    two.run_for(3s);
    two.start_hand();
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.events, outcome_of_run(two.plan).events) << "time begins with the session";
}

// The link takes 50 ms to hand over a message, as with a hand that is slow to read. Nothing is lost, and the
// queue never holds much more than one packet deadline's events.
TEST(CoprocessorNode, WaitsInLockstepForWhatIsQueued) {
    TwoNodes two(
        "duration_s: 1 patch { name: 'skin' elements: 5000 } link { tcp {} encoding: FIXED_WIDTH } "
        "source { profile { point { time_s: 0 force_n: 20 } } }");
    two.links.set_latency(50ms);
    two.start_in_lockstep();
    std::size_t most_bytes = 0;
    const MonotonicTime end = two.now + std::chrono::minutes(10);
    while (two.now < end && !(two.hand.ended && two.coprocessor.ended)) {
        two.run_for(1ms);
        if (const CoprocessorSession* session = two.coprocessor.node->session())
            most_bytes = std::max(most_bytes, session->queued_bytes());
    }
    EXPECT_EQ(two.coprocessor.events, outcome_of_run(two.plan).events);
    EXPECT_EQ(two.hand.node->report().received.events, two.coprocessor.events.size());
    EXPECT_GT(two.coprocessor.events.size() * 4, 4 * LinkOptions{}.queue_bytes) << "too little to tell";
    // At one time every element fires: 5,000 events in fixed width, in one deadline.
    EXPECT_LT(most_bytes, LinkOptions{}.queue_bytes + 5000 * 8);
}

TEST(CoprocessorNode, DoesNothingInLockstepWhileTheQueueIsFull) {
    TwoNodes two(press());
    two.start_in_lockstep();
    two.links.set_queued_bytes(LinkOptions{}.queue_bytes);
    two.run_for(1s);
    EXPECT_EQ(two.coprocessor.node->report().sessions, 1U);
    EXPECT_EQ(two.coprocessor.node->at(), scene_start);
    two.links.set_queued_bytes(LinkOptions{}.queue_bytes - 1);
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.node->at(), scene_start + 2s);
}

// Neither end goes on before it hears how far the other has come, and the first packet is far off.
TEST(CoprocessorNode, TellsInLockstepThatNoPacketEndsBeforeTheFirst) {
    TwoNodes two(press("packet_ms: 500 heartbeat_ms: 500 freeze_ms: 1000 safe_ms: 1500"));
    two.start_in_lockstep();
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.node->at(), scene_start + 2s);
    EXPECT_EQ(two.hand.steps.size(), 2000U);
}

// The neurons go on without the hand, and the next hand hears how many events it has missed.
TEST(CoprocessorNode, GoesOnInRealTimeWhileItLooksForTheNextHand) {
    TwoNodes two(press());
    two.start();
    two.run_for(700ms);
    two.kill_hand();
    two.run_for(500ms);
    two.start_hand();
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.node->report().sessions, 2U);
    EXPECT_EQ(two.coprocessor.node->report().broken_sessions, 1U);
    EXPECT_EQ(two.coprocessor.started_over, 0);
    EXPECT_EQ(two.coprocessor.events, outcome_of_run(two.plan).events);
    const PacketCounts received = two.hand.node->report().received;
    EXPECT_GT(received.lost_events, 10U);
    EXPECT_EQ(received.events + received.lost_events, two.coprocessor.events.size());
    EXPECT_EQ(two.hand.node->at(), scene_start + 2s);
    EXPECT_NEAR(two.hand.steps.at(0)[0], 1.2, 0.03) << "the hand begins where the coprocessor is";
}

// A hand that gives a session up may have another in real time; in lockstep nothing can follow it.
TEST(CoprocessorNode, LooksAgainInRealTimeForAHandThatHasGivenUp) {
    for (const bool lockstep : {false, true}) {
        TwoNodes two(press());
        RawHand hand(two.links);
        two.start_coprocessor({.lockstep = lockstep});
        two.run_for(100ms);
        ASSERT_EQ(hand.hellos, 1);
        proto::Envelope bye;
        bye.mutable_bye()->set_reason(proto::FAILURE);
        bye.mutable_bye()->set_text("lost its mind");
        hand.say(bye);
        two.run_for(1s);
        EXPECT_EQ(hand.hellos, lockstep ? 1 : 2);
        EXPECT_EQ(two.coprocessor.ended, lockstep);
    }
}

// Positions are sent modulo 82 s, and taken for the nearest; a new hand has to be told the whole of it.
TEST(CoprocessorNode, TellsANewHandWhereInALongSceneItIs) {
    TwoNodes two(press("", 70));
    two.start();
    two.run_for(60s);
    two.kill_hand();
    two.start_hand();
    two.run_to_the_end();
    const PacketCounts received = two.hand.node->report().received;
    EXPECT_GT(received.events, 100U);
    EXPECT_EQ(received.refused + received.out_of_order, 0U);
    EXPECT_EQ(received.events + received.lost_events, two.coprocessor.events.size());
}

TEST(CoprocessorNode, StartsOverWithAHandThatHasTheSamples) {
    TwoNodes two(grasp());
    two.start();
    two.run_for(700ms);
    two.kill_hand();
    two.run_for(100ms);
    const CoprocessorNode::Report before = two.coprocessor.node->report();
    EXPECT_EQ(before.times_begun, 1U);
    EXPECT_EQ(before.counts.events, two.coprocessor.events.size());
    two.start_hand();
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.started_over, 1);
    // All counts are of both times, or all of the last.
    const CoprocessorNode::Report after = two.coprocessor.node->report();
    EXPECT_EQ(after.times_begun, 2U);
    EXPECT_EQ(after.counts.events, two.coprocessor.events.size());
    EXPECT_EQ(after.since_begin.events, outcome_of_run(two.plan).events.size());
    EXPECT_GT(before.counts.packet_bytes, 100U);
    // What was under way when the hand ended comes to what was counted then.
    EXPECT_GE(after.counts.packet_bytes - after.since_begin.packet_bytes, before.counts.packet_bytes);
    EXPECT_GE(after.counts.samples - after.since_begin.samples, before.counts.samples);
    EXPECT_LT(after.counts.samples - after.since_begin.samples, before.counts.samples + 100);
    Summary summary = summary_of(*two.coprocessor.node);
    EXPECT_EQ(summary["events"].number(), after.counts.events);
    EXPECT_EQ(summary["link_bytes"].number(), after.counts.packet_bytes);
    Summary& last = summary["since_last_begin"];
    EXPECT_EQ(last["packets"].number(), after.since_begin.packets);
    EXPECT_EQ(last["link_bytes"].number(), after.since_begin.packet_bytes);
    EXPECT_EQ(last["late_scans"].number(), 0) << "known of the last time alone";
    EXPECT_EQ(summary.find("late_scans"), nullptr);
    EXPECT_EQ(but_for_the_first_gains(two.hand.steps),
              but_for_the_first_gains(outcome_of_run(two.plan).steps));
}

// Its clock begins with the hand's first message, and that is as far behind as the message was held up. The
// samples after it are not, but for a few: its packets are late only until it has seen that.
TEST(CoprocessorNode, ComesNearerWhereTheFirstMessageWasHeldUp) {
    TwoNodes two(grasp("", 30));
    two.links.set_latency(8ms);
    two.start();
    while (two.hand.session.empty()) two.run_for(1ms);
    two.links.set_latency(0ms);
    const auto run_on = [&](int for_s) {
        for (int second = 0; second < for_s; ++second) {
            two.run_for(980ms);
            two.links.set_latency(9ms);
            two.run_for(20ms);
            two.links.set_latency(0ms);
        }
        return two.hand.node->report().received;
    };
    const PacketCounts begun = run_on(5);
    EXPECT_GT(begun.late, begun.packets / 2);
    const PacketCounts then = run_on(15);
    const PacketCounts now = run_on(9);
    EXPECT_LT(20 * (now.late - then.late), now.packets - then.packets);
    // And no nearer than that nearly all scans come in time, each of the three samples of a patch.
    const CoprocessorNode::Report report = two.coprocessor.node->report();
    EXPECT_LT(20 * two.coprocessor.node->link_end().coprocessor().late_scans(), report.counts.samples / 3);
}

// Half of the scans are early, and the others as late as the first message was.
TEST(CoprocessorNode, KeepsItsDistanceWhereManyScansAreLate) {
    TwoNodes two(grasp("", 30));
    two.links.set_latency(8ms);
    two.start();
    while (two.hand.session.empty()) two.run_for(1ms);
    for (int i = 0; i < 500; ++i) {
        two.links.set_latency(i % 2 == 0 ? 0ms : 8ms);
        two.run_for(20ms);
    }
    const CoprocessorNode::Report report = two.coprocessor.node->report();
    EXPECT_GT(report.counts.samples, 5'000U);
    EXPECT_LT(20 * two.coprocessor.node->link_end().coprocessor().late_scans(), report.counts.samples / 3);
}

TEST(CoprocessorNode, KeepsItsOwnTimeWhereItHasTheSamples) {
    TwoNodes two(press("", 20));
    RawHand hand(two.links);
    two.start_coprocessor();
    two.run_for(10ms);
    const MonotonicTime welcomed = two.now;
    hand.probe();
    two.run_for(1ms);
    ASSERT_TRUE(hand.last_echo);
    const TimePoint told = *hand.last_echo;
    for (const Duration ahead : {Duration(0), Duration(-50ms), Duration(-50ms)}) {
        hand.probe(ahead);
        two.run_for(800ms);
    }
    const Duration passed = two.now - welcomed;
    hand.probe();
    two.run_for(1ms);
    EXPECT_EQ(*hand.last_echo - told, passed);
}

// The distance that it keeps is that of the first probe after its beginning; it has no time before that.
TEST(CoprocessorNode, HearsHowFarItIsAheadOnlyOnceItHasBegun) {
    TwoNodes two(grasp("", 20));
    RawHand hand(two.links);
    two.start_coprocessor();
    two.run_for(10ms);
    hand.probe(Duration(1s));
    two.run_for(10ms);
    EXPECT_FALSE(hand.last_echo);
    const MonotonicTime began = two.now;
    proto::Envelope clock;
    clock.mutable_clock()->set_time_ns(0);
    hand.say(clock);
    for (int i = 0; i < 3; ++i) {
        hand.probe(Duration(8ms));
        two.run_for(800ms);
    }
    const Duration passed = two.now - began;
    hand.probe();
    two.run_for(1ms);
    ASSERT_TRUE(hand.last_echo);
    EXPECT_EQ(*hand.last_echo - scene_start, passed);
}

// What one end has sent the other has received.
TEST(CoprocessorNode, CountsTheBytesThatTheHandCounts) {
    TwoNodes two(press("", 2));
    two.start();
    two.run_for(10s);
    EXPECT_TRUE(two.coprocessor.ended && two.hand.ended);
    const LinkTotals ours = two.coprocessor.node->report().link;
    const LinkTotals theirs = two.hand.node->report().link;
    EXPECT_GT(ours.bytes_sent, 1'000U);
    EXPECT_EQ(ours.bytes_sent, theirs.bytes_received);
    EXPECT_GT(ours.bytes_received, 100U);
    EXPECT_EQ(ours.bytes_received, theirs.bytes_sent);
}

TEST(CoprocessorNode, TriesAgainWithoutHasteWhereTheHandHasAnother) {
    const Duration patience = 3s;
    TwoNodes two(press("connect_s: 3", 20));
    two.start();
    two.run_for(500ms);
    // The hand is restarted, and another coprocessor gets to it first.
    TestCoprocessorNode first = std::move(two.coprocessor);
    two.kill_hand();
    two.start_hand();
    two.start_coprocessor();
    two.run_for(100ms);
    EXPECT_EQ(two.hand.node->report().sessions, 1U);
    const MonotonicTime began = two.now;
    while (two.now < began + 10s && first.node->poll()) two.run_for(10ms);
    ASSERT_TRUE(first.node->failure());
    EXPECT_GE(two.now - began, patience);
    EXPECT_LE(two.now - began, patience + 500ms);
    EXPECT_NEAR(static_cast<double>(two.hand.node->report().refused_peers), 12, 2) << "four times a second";
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
}

TEST(CoprocessorNode, RefusesAClockOutsideOfTheScene) {
    TwoNodes two(grasp());
    RawHand hand(two.links);
    two.start_coprocessor();
    two.run_for(10ms);
    proto::Envelope clock;
    clock.mutable_clock()->set_time_ns(Duration(3s).count());
    hand.say(clock);
    two.run_for(1s);
    EXPECT_TRUE(two.coprocessor.ended);
    EXPECT_EQ(two.coprocessor.node->failure(), "the hand sends a clock outside of the scene");
}

TEST(CoprocessorNode, RefusesAnAcknowledgementOfWhatItHasNotSent) {
    TwoNodes two(grasp("encoding: PREDICTED channel { loss: 0.1 }"));
    ASSERT_TRUE(two.plan.packets->acknowledged);
    RawHand hand(two.links);
    two.start_coprocessor();
    two.run_for(10ms);
    proto::Envelope message;
    // Of the beginning, which asks for it anew; and of a time far ahead of the first packets.
    for (const std::uint32_t position : {0U, 2000U}) {
        message.mutable_acknowledgement()->set_position(position);
        hand.say(message);
        two.run_for(10ms);
        EXPECT_EQ(two.coprocessor.node->report().link.refused_frames, position == 0 ? 0U : 1U);
    }
    EXPECT_EQ(two.coprocessor.node->session()->last_refusal(),
              "an acknowledgement of packets that have not been sent");
}

TEST(CoprocessorNode, RefusesSamplesFromFarAhead) {
    TwoNodes two(grasp("", 60));
    RawHand hand(two.links);
    two.start_coprocessor();
    two.run_for(10ms);
    proto::Envelope message;
    message.mutable_clock()->set_time_ns(0);
    hand.say(message);
    for (const Duration time : {Duration(9s), Duration(11s)}) {
        two.run_for(10ms);
        EXPECT_FALSE(two.coprocessor.node->failure());
        message.mutable_samples()->set_time_ns(time.count());
        message.mutable_samples()->add_force_n(0);
        hand.say(message);
    }
    two.run_for(10ms);
    ASSERT_TRUE(two.coprocessor.node->failure());
    EXPECT_EQ(two.coprocessor.node->failure()->find("the hand sends samples from 11"), 0U)
        << *two.coprocessor.node->failure();
}

TEST(CoprocessorNode, BeginsWithSamplesWhereTheClockWasLost) {
    TwoNodes two(grasp());
    two.links.set_carries([](const proto::Envelope* message) { return !message || !message->has_clock(); });
    two.start();
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.events, outcome_of_run(two.plan).events);
}

TEST(CoprocessorNode, TellsTheHandThatANeuronFiresWithoutBounds) {
    TwoNodes two(press("", 2, R"(
        patch { name: "hot" elements: 1 encoder { sustained { gain_mv_per_n: 1 bias_mv: 1e6 } } }
        runtime { spikes_per_window: 100 }
        gain { accept_unreachable_limit: true })"));
    two.start();
    two.run_for(1s);
    EXPECT_TRUE(two.coprocessor.ended);
    ASSERT_TRUE(two.coprocessor.node->failure());
    EXPECT_NE(two.coprocessor.node->failure()->find("bias_mv 1e+06"), std::string::npos);
    EXPECT_NE(two.hand.last_of_session().find("bias_mv 1e+06"), std::string::npos)
        << two.hand.last_of_session();
}

TEST(CoprocessorNode, OpensAnotherSessionForAHandThatNeedsOneWithoutHaste) {
    TwoNodes two(press("", 10));
    RawHand hand(two.links);
    two.start_coprocessor();
    two.run_for(300ms);
    EXPECT_EQ(hand.hellos, 1);
    proto::Envelope status;
    status.mutable_status()->set_state(proto::SAFE);
    hand.say(status);
    two.run_for(100ms);
    EXPECT_EQ(hand.hellos, 1) << "a hand that is safe without need of it";
    status.mutable_status()->set_needs_session(true);
    status.mutable_status()->set_reason("no packet for 150 ms");
    for (int i = 0; i < 200; ++i) {
        hand.say(status);
        two.run_for(10ms);
    }
    EXPECT_NEAR(hand.hellos, 9, 1) << "four times a second at most";
    EXPECT_EQ(two.coprocessor.session.at(1),
              "the session has broken off: the hand is safe until another session: no packet for 150 ms");
    EXPECT_FALSE(two.coprocessor.ended);
}

TEST(CoprocessorNode, HearsOfTheGain) {
    TwoNodes two(press());
    two.start();
    EXPECT_TRUE(std::isnan(two.coprocessor.node->report().hand_gain));
    two.run_for(1s);
    // A gain of the last 60 ms: the hand tells its state every 50 ms, and looks after that every 10.
    const double told = two.coprocessor.node->report().hand_gain;
    ASSERT_GE(two.hand.steps.size(), 60U);
    EXPECT_TRUE(std::any_of(two.hand.steps.end() - 60, two.hand.steps.end(), [told](const auto& step) {
        return step[4] == told;
    })) << told;
}

// Everything is sent before the bye: the hand knows every event.
TEST(CoprocessorNode, ThatIsInterruptedLeavesNothingUntold) {
    TwoNodes two(press("packet_ms: 20"));
    std::vector<Event> expected = outcome_of_run(two.plan).events;
    // An event early in a packet, and the scan after it: then comes the interrupt.
    const auto event = std::find_if(expected.begin(), expected.end(), [](const Event& e) {
        return e.time > scene_start + 500ms && e.time.time_since_epoch() % 20ms < 10ms;
    });
    ASSERT_NE(event, expected.end());
    const TimePoint scan = scene_start + (event->time.time_since_epoch() / 5ms + 1) * 5ms;
    std::erase_if(expected, [scan](const Event& e) { return e.time >= scan; });
    two.start();
    two.run_for(scan - scene_start + 1ms);
    two.coprocessor.node->interrupt();
    two.run_to_the_end();
    EXPECT_EQ(two.coprocessor.node->at(), scan);
    EXPECT_EQ(two.coprocessor.events, expected);
    EXPECT_EQ(two.hand.events.size(), two.coprocessor.events.size());
    EXPECT_EQ(two.hand.node->report().received.lost_events, 0U);
}

TEST(CoprocessorNode, SaysGoodbyeOnceHoweverOftenItIsInterrupted) {
    const auto file =
        std::filesystem::temp_directory_path() / ("afferent-" + std::to_string(::getpid()) + ".byes");
    TwoNodes two(press());
    two.start({}, {.record = file});
    two.run_for(2s);
    for (int i = 0; i < 3; ++i) two.coprocessor.node->interrupt();
    two.run_to_the_end();
    EXPECT_TRUE(two.coprocessor.node->close());
    auto recording = value_or_throw(RecordingReader::open(file));
    proto::Entry entry;
    int byes = 0;
    while (value_or_throw(recording.next(entry))) byes += entry.link().has_bye();
    EXPECT_EQ(byes, 1);
    std::filesystem::remove(file);
}

TEST(CoprocessorNode, RecordsWhatReplaysToWhatTheHandDid) {
    const auto file =
        std::filesystem::temp_directory_path() / ("afferent-" + std::to_string(::getpid()) + ".sent");
    TwoNodes two(press());
    two.start({}, {.record = file});
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_TRUE(two.coprocessor.node->close());
    Steps steps;
    Observer output;
    output.step = [&](const ControllerStep& step) { steps.push_back(numbers(step)); };
    auto replay = Replay::open(file, std::move(output));
    ASSERT_TRUE(replay) << replay.error().text;
    while (value_or_throw(replay.value()->next())) replay.value()->step();
    EXPECT_EQ(replay.value()->recorded(), proto::COPROCESSOR);
    EXPECT_EQ(but_for_the_first_gains(steps), but_for_the_first_gains(two.hand.steps));
    std::filesystem::remove(file);
}

}  // namespace
}  // namespace afferent
