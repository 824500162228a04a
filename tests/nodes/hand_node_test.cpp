// A hand on a link: alone, with a coprocessor, with several one after another. In virtual time.
#include "afferent/nodes/hand_node.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/scene/plan.hpp"
#include "tests/long_runs.hpp"
#include "tests/nodes/two_nodes.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

constexpr std::size_t time_of = 0;
constexpr std::size_t gain_of = 4;
constexpr std::size_t command_of = 8;

// The steps in [begin, end), in seconds.
Steps between(const Steps& steps, double begin_s, double end_s) {
    Steps found;
    std::copy_if(steps.begin(), steps.end(), std::back_inserter(found),
                 [&](const auto& step) { return step[time_of] >= begin_s && step[time_of] < end_s; });
    EXPECT_FALSE(found.empty());
    return found;
}

bool all(const Steps& steps, std::size_t what, double value) {
    return std::all_of(steps.begin(), steps.end(), [&](const auto& step) { return step[what] == value; });
}

// A thread for the grip is for real time: in lockstep there is none, also where one is asked for.
TEST(HandNode, InLockstepComesToWhatARunDoes) {
    for (const auto& [scene, grip_thread] : {std::pair(grasp(), false), {press(), false}, {press(), true}}) {
        TwoNodes two(scene);
        two.start({.lockstep = true, .grip_thread = grip_thread}, {.lockstep = true});
        two.run_to_the_end();
        const RunOutcome run = outcome_of_run(two.plan);
        EXPECT_GT(run.events.size(), 50U);
        EXPECT_EQ(two.coprocessor.events, run.events);
        EXPECT_EQ(without_truth(two.hand.steps), without_truth(run.steps));
        EXPECT_EQ(two.hand.node->report().received.events, run.events.size());
        EXPECT_EQ(two.hand.node->at(), scene_start + 2s);
        EXPECT_EQ(two.hand.node->failure(), std::nullopt);
    }
}

TEST(HandNode, InRealTimeOverAPerfectLinkComesToWhatARunDoes) {
    for (const std::string& scene : {grasp(), press()}) {
        TwoNodes two(scene);
        two.start();
        two.run_to_the_end();
        const RunOutcome run = outcome_of_run(two.plan);
        EXPECT_EQ(two.coprocessor.events, run.events);
        EXPECT_EQ(but_for_the_first_gains(two.hand.steps), but_for_the_first_gains(run.steps));
        EXPECT_TRUE(all(between(two.hand.steps, 0, 0.06), gain_of, 0)) << "it is safe at first";
        ASSERT_TRUE(two.hand.node->pacer());
        EXPECT_EQ(two.hand.node->pacer()->missed_deadlines(), 0U);
        EXPECT_EQ(two.hand.node->report().interrupted_sessions, 0U) << "the scene has ended";
        EXPECT_TRUE(two.hand.safe.empty());
        EXPECT_EQ(two.hand.about_to_start_over, 0);
    }
}

TEST(HandNode, CountsPacketsThatComeTooLate) {
    TwoNodes two(press("delivery_ms: 5"));
    two.start();
    two.run_for(500ms);
    EXPECT_EQ(two.hand.node->report().received.late, 0U);
    const std::uint64_t before = two.hand.node->report().received.packets;
    two.links.set_latency(6ms);
    two.run_to_the_end();
    const PacketCounts received = two.hand.node->report().received;
    EXPECT_GT(received.packets, before + 50);
    EXPECT_GE(received.late + 2, received.packets - before) << "but for those at the change";
    EXPECT_EQ(received.stale, 0U);
    EXPECT_EQ(received.events, two.coprocessor.events.size()) << "what is late is decoded all the same";
}

TEST(HandNode, RefusesPacketsOfLongAgoAndTakesThemForNoSignOfLife) {
    TwoNodes two(press("delivery_ms: 5 stale_ms: 20"));
    two.start();
    two.run_for(1s);
    two.links.set_latency(30ms);
    two.run_for(500ms);
    const HandNode::Report report = two.hand.node->report();
    EXPECT_GT(report.received.stale, 5U);
    EXPECT_EQ(report.state, GripState::safe);
    EXPECT_EQ(two.hand.safe, std::vector<std::string>{"packets are 30 ms old when they arrive"});
    EXPECT_GT(report.received.lost_events, 0U);
}

TEST(HandNode, TellsOfWhichTimeItsPacketsWereLost) {
    TwoNodes two(press());
    two.start();
    two.run_for(1s);
    EXPECT_TRUE(two.hand.gaps.empty());
    two.links.set_carries([](const auto*) { return false; });
    two.run_for(40ms);
    two.links.set_carries([](const auto*) { return true; });
    two.run_for(500ms);
    ASSERT_EQ(two.hand.gaps.size(), 1U);
    const TimeSpan gap = two.hand.gaps.front();
    EXPECT_GE(gap.end - gap.begin, 30ms);
    EXPECT_LE(gap.end - gap.begin, 60ms);
    const auto is_in_gap = [&](const Event& event) {
        return gap.begin <= event.time && event.time < gap.end;
    };
    EXPECT_TRUE(std::ranges::none_of(two.hand.events, is_in_gap));
    EXPECT_GT(std::ranges::count_if(two.coprocessor.events, is_in_gap), 0);
}

TEST(HandNode, FreezesAndGoesSafeByTimeAlone) {
    TwoNodes two(reach("safe_state: OPEN"));
    two.start();
    two.run_for(700ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
    two.links.set_carries([](const auto*) { return false; });
    two.run_for(Duration(5s));
    const Steps& steps = two.hand.steps;
    EXPECT_EQ(steps.size(), 2000U) << "the hand goes on to the scene's end";
    // The last packet came at 0.7 s, or a heartbeat of 25 ms before.
    EXPECT_GT(between(steps, 0.73, 0.735).at(0)[gain_of], 0);
    EXPECT_TRUE(all(between(steps, 0.761, 2), gain_of, 0));
    EXPECT_TRUE(all(between(steps, 0.851, 2), command_of, -0.5)) << "it opens";
    EXPECT_EQ(two.hand.safe, std::vector<std::string>{"no packet for 150 ms"});
    EXPECT_EQ(two.hand.node->report().freezes, 1U);
    EXPECT_EQ(two.hand.node->report().safe_states, 1U);
    // Silence came first; a second later the session is given up.
    EXPECT_EQ(two.hand.last_of_session(), "the session has broken off: the peer has been silent for 1000 ms");
}

TEST(HandNode, OperatesAgainWithTheNextSessionAndNotBefore) {
    TwoNodes two(reach());
    two.start();
    two.run_for(700ms);
    two.kill_coprocessor();
    two.run_for(400ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    EXPECT_EQ(two.hand.node->report().reason, "no packet for 150 ms: the session has ended");
    two.start_coprocessor();
    two.run_to_the_end();
    const HandNode::Report report = two.hand.node->report();
    EXPECT_EQ(report.sessions, 2U);
    EXPECT_EQ(report.broken_sessions, 1U);
    EXPECT_EQ(report.interrupted_sessions, 0U) << "without a bye";
    EXPECT_EQ(report.state, GripState::operating);
    EXPECT_TRUE(all(between(two.hand.steps, 0.761, 1.16), gain_of, 0)) << "a hello alone changes nothing";
    EXPECT_FALSE(all(between(two.hand.steps, 1.16, 1.21), gain_of, 0)) << "its packets do";
    EXPECT_EQ(two.hand.started_over, 0) << "its own clock goes on";
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_EQ(two.coprocessor.node->at(), scene_start + 2s) << "the new one has followed it";
}

TEST(HandNode, StartsOverWithACoprocessorThatHasTheSamples) {
    TwoNodes two(press());
    two.start();
    two.run_for(700ms);
    two.kill_coprocessor();
    two.run_for(100ms);
    two.start_coprocessor();
    two.run_to_the_end();
    EXPECT_EQ(two.hand.about_to_start_over, 1);
    EXPECT_EQ(two.hand.started_over, 1);
    ASSERT_FALSE(two.hand.steps.empty());
    const auto again = std::find_if(two.hand.steps.begin() + 1, two.hand.steps.end(),
                                    [](const auto& step) { return step[time_of] == 0; });
    EXPECT_EQ(but_for_the_first_gains(Steps(again, two.hand.steps.end())),
              but_for_the_first_gains(outcome_of_run(two.plan).steps));
}

TEST(HandNode, RefusesACoprocessorOfAnotherSceneAndWaitsForTheNext) {
    const Plan other = make_plan(Scene::from_text(press("", 2, "seed: 9")));
    TwoNodes two(press());
    two.start_hand();
    two.start_coprocessor(other);
    two.run_for(100ms);
    EXPECT_TRUE(two.coprocessor.ended);
    ASSERT_TRUE(two.coprocessor.node->failure());
    EXPECT_NE(two.coprocessor.node->failure()->find("the hand refuses: the scenes differ in seed"),
              std::string::npos)
        << *two.coprocessor.node->failure();
    EXPECT_EQ(two.hand.node->report().broken_sessions, 0U) << "there was none";
    two.start_coprocessor();
    two.run_to_the_end();
    EXPECT_EQ(two.hand.node->report().sessions, 1U);
    EXPECT_EQ(two.hand.steps.size(), 2000U);
}

TEST(HandNode, StaysSafeWhenAStrangerKnocks) {
    const Plan other = make_plan(Scene::from_text(grasp("", 2, "seed: 9")));
    TwoNodes two(grasp());
    two.start();
    two.run_for(500ms);
    two.kill_coprocessor();
    two.run_for(300ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    two.start_coprocessor(other);
    two.run_for(300ms);
    EXPECT_TRUE(two.coprocessor.ended);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    EXPECT_EQ(two.hand.node->report().safe_states, 1U);
    EXPECT_EQ(two.hand.node->report().reason, "no packet for 150 ms: the session has ended");
    EXPECT_TRUE(all(between(two.hand.steps, 0.66, 1.1), gain_of, 0));
}

// Says hello as a coprocessor of the scene does, and then sends what it is told to.
class RawCoprocessor {
  public:
    // Its clock shows this time of the scene at this moment.
    explicit RawCoprocessor(TwoNodes& two, Duration shows = 0ms, bool lockstep = false)
        : connector_(two.links.connector()) {
        connector_->start(
            [this, &two, lockstep, began = two.now - shows](Result<std::unique_ptr<Link>> link) {
                link_ = value_or_throw(std::move(link));
                link_->start({.message =
                                  [this, &two, began](const proto::Envelope& message) {
                                      if (!message.has_probe()) return;
                                      proto::Envelope echo;
                                      echo.mutable_echo()->set_number(message.probe().number());
                                      echo.mutable_echo()->set_time_ns((two.now - began).count());
                                      link_->send(echo);
                                  },
                              .bad_frame = [](const auto&) {},
                              .closed = [](const auto&) {}});
                proto::Envelope hello;
                *hello.mutable_hello() = make_hello(two.plan, lockstep);
                link_->send(hello);
            });
    }
    void say_clock(Duration time) {
        proto::Envelope message;
        message.mutable_clock()->set_time_ns(time.count());
        send(message);
    }
    void send(const proto::Envelope& packet) {
        if (!link_) throw std::runtime_error("it has not connected");
        link_->send(packet);
    }

  private:
    std::unique_ptr<Connector> connector_;
    std::unique_ptr<Link> link_;
};

TEST(HandNode, WithoutAThreadHasItsLoopHearOfASessionAtOnce) {
    TwoNodes two(press());
    two.start_hand();
    RawCoprocessor coprocessor(two);
    for (int i = 0; i < 100 && two.hand.node->grip().sessions == 0; ++i) two.links.deliver();
    EXPECT_EQ(two.hand.node->grip().sessions, 1U) << "it has not been polled since the hello";
}

TEST(HandNode, RefusesAPlaceOutsideOfTheScene) {
    TwoNodes two(press());
    two.start_hand();
    RawCoprocessor coprocessor(two);
    two.run_for(10ms);
    coprocessor.say_clock(2001ms);
    two.run_for(1s);
    EXPECT_FALSE(two.hand.ended) << "only its own user ends a hand";
    EXPECT_EQ(two.hand.last_of_session(),
              "the session has broken off: the coprocessor is at 2.001000 s, outside of the scene");
    EXPECT_TRUE(two.hand.steps.empty());
}

// The scene's end, and a second for the rest of what a coprocessor has to say.
TEST(HandNode, EndsWithItsSceneAndWaitsASecondForACoprocessorThatIsThere) {
    TwoNodes alone(press());
    alone.start();
    alone.run_for(1500ms);
    alone.kill_coprocessor();
    alone.run_for(510ms);
    EXPECT_TRUE(alone.hand.ended);
    TwoNodes two(press());
    two.start_hand();
    RawCoprocessor coprocessor(two);
    two.run_for(10ms);
    coprocessor.say_clock(10ms);
    two.run_for(2900ms);
    EXPECT_EQ(two.hand.steps.size(), 1990U);
    EXPECT_FALSE(two.hand.ended);
    two.run_for(700ms);
    EXPECT_TRUE(two.hand.ended);
}

TEST(HandNode, TellsItsStatusTwentyTimesASecondAndWhyItDoesNotOperate) {
    int told = 0;
    int operating = 0;
    const auto count = [&](const proto::Envelope* message) {
        if (!message || !message->has_status()) return true;
        const bool operates = message->status().state() == proto::OPERATING;
        EXPECT_EQ(message->status().reason().empty(), operates);
        ++told;
        operating += operates;
        return true;
    };
    TwoNodes unheard(press());
    unheard.links.set_carries(count);
    unheard.start_hand();
    RawCoprocessor silent(unheard);
    unheard.run_for(500ms);
    EXPECT_EQ(told, 0) << "it has not begun";
    silent.say_clock(500ms);
    unheard.run_for(500ms);
    EXPECT_NEAR(told, 10, 2);
    EXPECT_EQ(operating, 0);
    told = 0;
    TwoNodes two(press());
    two.links.set_carries(count);
    two.start();
    two.run_for(1s);
    EXPECT_NEAR(told, 20, 2);
    EXPECT_GT(operating, 10);
}

// It is steered by half a millisecond in a second towards a coprocessor that is ahead, while that is there.
TEST(HandNode, IsSteeredByNobodyOnceItsSessionHasEnded) {
    TwoNodes two(press("", 20));
    two.start_hand();
    {
        RawCoprocessor coprocessor(two, 900ms);
        two.run_for(10ms);
        coprocessor.say_clock(0ms);
        two.run_for(2s);
        ASSERT_TRUE(two.hand.node->pacer());
        EXPECT_GT(two.hand.node->pacer()->scene_time(two.now), scene_start + 2000ms + 500us);
    }
    two.run_for(50ms);
    EXPECT_EQ(two.hand.node->session(), nullptr);
    ASSERT_TRUE(two.hand.node->pacer());
    const TimePoint before = two.hand.node->pacer()->scene_time(two.now);
    two.run_for(4s);
    EXPECT_EQ(two.hand.node->pacer()->scene_time(two.now) - before, 4s);
}

TEST(HandNode, InRealTimeGoesOnHoweverLongItsCoprocessorIsGone) {
    TwoNodes two(grasp("connect_s: 1", 5));
    two.start();
    two.run_for(500ms);
    two.kill_coprocessor();
    two.run_for(5s);
    EXPECT_EQ(two.hand.node->failure(), std::nullopt);
    EXPECT_EQ(two.hand.steps.size(), 5000U);
}

TEST(HandNode, InLockstepWaitsForItsFirstCoprocessorForEver) {
    TwoNodes two(grasp("connect_s: 1"));
    two.start_hand({.lockstep = true});
    two.run_for(10s);
    EXPECT_FALSE(two.hand.ended);
    EXPECT_EQ(two.hand.node->failure(), std::nullopt);
}

TEST(HandNode, InLockstepEndsWithACoprocessorThatIsInterrupted) {
    TwoNodes two(grasp());
    two.links.set_latency(1ms);
    two.start_in_lockstep();
    two.run_for(100ms);
    two.coprocessor.node->interrupt();
    two.run_for(1s);
    EXPECT_TRUE(two.hand.ended);
    EXPECT_LT(two.hand.steps.size(), 2000U);
    EXPECT_LT(two.hand.node->at(), scene_start + 2s);
    EXPECT_EQ(two.hand.node->failure(), std::nullopt);
}

TEST(HandNode, InLockstepFailsWithAPlaceOutsideOfTheScene) {
    TwoNodes two(press());
    two.start_hand({.lockstep = true});
    RawCoprocessor coprocessor(two, 0ms, true);
    two.run_for(10ms);
    coprocessor.say_clock(2001ms);
    two.run_for(10ms);
    EXPECT_EQ(two.hand.node->failure(), "the coprocessor is at 2.001000 s, outside of the scene");
}

TEST(HandNode, RefusesPacketsOfATimeThatIsStillToComeAndGoesOn) {
    TwoNodes two(press("", 10));
    two.start_hand();
    RawCoprocessor coprocessor(two);
    two.run_for(10ms);
    coprocessor.say_clock(0ms);
    const auto send = [&](Duration end) {
        Packetizer packetizer(packet_layout(two.plan));
        packetizer.begin_at(scene_start + end - 5ms);
        packetizer.push(std::vector{Event{scene_start + end - 5ms, 0}});
        packetizer.close(scene_start + end, [&](const auto& packet) { coprocessor.send(packet); });
        two.run_for(10ms);
    };
    two.run_for(80ms);
    send(2090ms);
    send(100ms);
    send(110ms);
    EXPECT_FALSE(two.hand.ended);
    const PacketCounts received = two.hand.node->report().received;
    EXPECT_EQ(received.refused, 1U);
    EXPECT_EQ(two.hand.node->report().link.refused_frames, 1U) << "it is among what the link refused, once";
    EXPECT_EQ(received.events, 2U);
    EXPECT_EQ(received.stale, 0U);
}

// Takes a link for one on which packets may overtake each other.
class UnorderedListener final : public Listener {
  public:
    explicit UnorderedListener(std::unique_ptr<Listener> listener) : listener_(std::move(listener)) {}
    void start(std::function<void(std::unique_ptr<Link>)> on_peer) override {
        listener_->start([on_peer = std::move(on_peer)](std::unique_ptr<Link> link) {
            on_peer(std::make_unique<UnorderedLink>(std::move(link)));
        });
    }
    LinkAddress address() const override { return listener_->address(); }
    std::uint64_t refused_peers() const override { return listener_->refused_peers(); }
    // Datagrams that belong to nobody.
    std::uint64_t strays() const override { return 3; }

  private:
    class UnorderedLink final : public Link {
      public:
        explicit UnorderedLink(std::unique_ptr<Link> link) : link_(std::move(link)) {}
        void start(LinkCallbacks callbacks) override { link_->start(std::move(callbacks)); }
        bool send(const proto::Envelope& message) override { return link_->send(message); }
        void close() override { link_->close(); }
        std::size_t queued_bytes() const override { return link_->queued_bytes(); }
        bool ordered() const override { return false; }
        const LinkCounts& counts() const override { return link_->counts(); }

      private:
        std::unique_ptr<Link> link_;
    };
    std::unique_ptr<Listener> listener_;
};

TEST(HandNode, CountsTheDatagramsThatBelongToNobodyAsForged) {
    TwoNodes two(press());
    two.start_hand(std::make_unique<UnorderedListener>(two.links.listener()));
    EXPECT_EQ(two.hand.node->report().link.forged_datagrams, 3U);
}

// A packet that waits for one that it has overtaken is a sign of life of the moment at which it came.
TEST(HandNode, FreezesByTheTimeAtWhichAPacketCameAndNotByHowLongItWaited) {
    TwoNodes two(press("delivery_ms: 23", 10));
    two.start_hand(std::make_unique<UnorderedListener>(two.links.listener()));
    RawCoprocessor coprocessor(two);
    two.run_for(10ms);
    coprocessor.say_clock(10ms);
    Packetizer packetizer(packet_layout(two.plan));
    packetizer.begin_at(scene_start + 10ms);
    for (Duration end = 15ms; end <= 210ms; end += 5ms) {
        two.run_for(5ms);
        packetizer.push(std::vector{Event{scene_start + end - 5ms, 0}});
        packetizer.close(scene_start + end, [&](const auto& packet) {
            if (end != 205ms) coprocessor.send(packet);
        });
    }
    two.run_for(22ms);
    const TimeSpan before_the_first{scene_start, scene_start + 10ms};
    EXPECT_EQ(two.hand.gaps, std::vector{before_the_first}) << "the one that is missing may still come";
    two.run_for(2ms);
    const TimeSpan missing{scene_start + 200ms, scene_start + 205ms};
    EXPECT_EQ(two.hand.gaps, (std::vector{before_the_first, missing}));
    two.run_for(35ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating) << "269 ms";
    two.run_for(2ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::frozen) << "60 ms after the packet came";
}

// Its packets are too old for good: after a second it is asked for another session.
TEST(HandNode, AsksACoprocessorThatBeganTooLateForAnotherSession) {
    TwoNodes two(grasp("", 10));
    two.links.set_latency(200ms);
    two.start();
    two.run_for(450ms);
    two.links.set_latency(0ms);
    two.run_for(650ms);
    EXPECT_EQ(two.hand.node->report().sessions, 1U);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    EXPECT_EQ(two.hand.node->grip().cause.kind, GripCause::Kind::stale_packets);
    two.run_for(500ms);
    EXPECT_EQ(two.hand.node->report().sessions, 2U);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
}

TEST(HandNode, BreaksOffASessionWhoseClockIsMoreThanASecondApart) {
    for (const Duration ahead : {900ms, 1100ms, -900ms, -1100ms}) {
        TwoNodes two(press("", 10));
        two.start_hand();
        RawCoprocessor coprocessor(two, 2s + ahead);
        two.run_for(10ms);
        coprocessor.say_clock(2010ms);
        two.run_for(200ms);
        EXPECT_EQ(two.hand.node->session() != nullptr, std::chrono::abs(ahead) < 1s);
        if (!two.hand.node->session()) {
            EXPECT_EQ(two.hand.last_of_session(),
                      "the session has broken off: the coprocessor's clock is " +
                          std::string(ahead > 0ms ? "1100 ms ahead of" : "1100 ms behind") + " the hand's");
        }
    }
}

// The two machines' clocks: up to 400 ms apart in the end, where packets of 52 ms are stale and those of 2 ms
// late.
TEST(HandNode, KeepsToAClockThatDriftsAway) {
    const int duration_s = long_runs ? 150 : 30;
    for (const std::string& scene : {press("", duration_s), grasp("", duration_s)})
        for (const double drift : {300e-6, -300e-6, 1000e-6, -1000e-6}) {
            TwoNodes two(scene);
            two.drift = drift;
            two.start();
            two.run_for(std::chrono::seconds(duration_s - 1));
            const HandNode::Report report = two.hand.node->report();
            EXPECT_EQ(report.received.stale, 0U);
            EXPECT_EQ(report.received.late, 0U);
            EXPECT_EQ(report.received.lost_events, 0U);
            EXPECT_EQ(report.state, GripState::operating);
            EXPECT_EQ(report.freezes, 0U);
            EXPECT_NEAR(seconds(two.coprocessor.node->at() - two.hand.node->at()), 0, 0.006);
        }
}

// From the very start, so that no packet is later than the one before it.
TEST(HandNode, KnowsALinkThatIsSlowerThanItPromised) {
    for (const std::string& scene : {press(), grasp()}) {
        TwoNodes two(scene);
        two.links.set_latency(115ms);
        two.start();
        two.run_for(1s);
        const PacketCounts received = two.hand.node->report().received;
        EXPECT_GT(received.stale, 20U);
        EXPECT_EQ(received.events, 0U);
        ASSERT_NE(two.hand.node->session(), nullptr);
        EXPECT_EQ(two.hand.node->session()->peer_clock().round_trip(), 230ms);
    }
}

TEST(HandNode, BeginsWithAPacketWhereTheClockWasLost) {
    TwoNodes two(press());
    two.links.set_carries([](const proto::Envelope* message) { return !message || !message->has_clock(); });
    two.start();
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_EQ(two.hand.node->report().received.events, two.coprocessor.events.size());
}

// Before the hand begins again, its clock still shows the time of the previous session.
TEST(HandNode, BeginsAnewWithAPacketWhereTheClockWasLost) {
    TwoNodes two(press("", 10));
    two.start();
    two.run_for(3s);
    two.kill_coprocessor();
    two.run_for(10ms);
    two.links.set_carries([](const proto::Envelope* message) { return !message || !message->has_clock(); });
    two.start_coprocessor();
    two.run_for(1s);
    const HandNode::Report report = two.hand.node->report();
    EXPECT_EQ(report.sessions, 2U);
    EXPECT_EQ(report.broken_sessions, 1U) << "that of the one that was killed";
    EXPECT_EQ(report.received.stale, 0U);
    EXPECT_EQ(report.state, GripState::operating);
    EXPECT_EQ(two.hand.started_over, 1);
}

TEST(HandNode, TurnsASecondCoprocessorAway) {
    TwoNodes two(press());
    two.start();
    two.run_for(500ms);
    TestCoprocessorNode first = std::move(two.coprocessor);
    two.start_coprocessor();
    two.run_for(5ms);
    EXPECT_FALSE(two.coprocessor.ended) << "the first may leave";
    EXPECT_EQ(two.hand.node->report().refused_peers, 1U);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
}

TEST(HandNode, SaysByeWhenItsUserEndsIt) {
    TwoNodes two(grasp());
    two.start();
    two.run_for(500ms);
    int byes = 0;
    two.links.set_carries([&](const proto::Envelope* message) {
        byes += message && message->has_bye();
        return true;
    });
    two.links.set_latency(1ms);
    two.hand.node->interrupt();
    two.hand.node->interrupt();
    two.run_for(500us);
    EXPECT_FALSE(two.hand.ended) << "it waits for the answer";
    two.run_for(20ms);
    EXPECT_TRUE(two.hand.ended);
    EXPECT_TRUE(two.coprocessor.ended);
    EXPECT_EQ(byes, 2) << "each end says it once";
    EXPECT_EQ(two.coprocessor.last_of_session(), "the session has ended: interrupted");
    EXPECT_EQ(two.hand.node->failure(), std::nullopt);
    EXPECT_EQ(two.hand.steps.size(), 501U);
    EXPECT_EQ(two.hand.node->report().broken_sessions, 0U);
    EXPECT_EQ(two.hand.node->report().interrupted_sessions, 0U) << "not by its peer";
}

TEST(HandNode, IsNotInterruptedByACoprocessorWhereBothEndAtOnce) {
    TwoNodes two(grasp());
    two.start();
    two.run_for(500ms);
    two.links.set_latency(5ms);
    two.hand.node->interrupt();
    two.coprocessor.node->interrupt();
    two.run_for(50ms);
    EXPECT_TRUE(two.hand.ended);
    EXPECT_TRUE(two.coprocessor.ended);
    EXPECT_EQ(two.hand.node->report().interrupted_sessions, 0U);
}

TEST(HandNode, IsNotEndedByACoprocessorsByeButFreezesAndGoesSafe) {
    TwoNodes two(reach());
    two.start();
    two.run_for(500ms);
    two.coprocessor.node->interrupt();
    two.run_for(20ms);
    EXPECT_TRUE(two.coprocessor.ended);
    EXPECT_EQ(two.hand.last_of_session(), "the session has ended: interrupted");
    EXPECT_EQ(two.hand.node->report().interrupted_sessions, 1U);
    EXPECT_FALSE(two.hand.ended);
    EXPECT_EQ(two.hand.node->report().state, GripState::frozen);
    two.run_for(200ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    two.start_coprocessor();
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U) << "its own clock ends it";
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
    EXPECT_TRUE(all(between(two.hand.steps, 0.502, 0.72), gain_of, 0));
}

// Samples on the coprocessor's end: its hello does not say where in the scene it is.
TEST(HandNode, StepsOnWhenASecondCoprocessorSaysHelloAndNothingElse) {
    TwoNodes two(press());
    two.start();
    two.run_for(500ms);
    two.kill_coprocessor();
    two.run_for(20ms);
    RawCoprocessor silent(two);
    two.run_for(5s);
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_EQ(two.hand.started_over, 0);
    EXPECT_TRUE(all(between(two.hand.steps, 0.561, 2), gain_of, 0));
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    EXPECT_TRUE(two.hand.ended) << "its own clock ends it";
}

// Whichever end has paused: below the safe threshold the hand goes on, beyond it another session re-arms it,
// which the coprocessor opens because the hand asks for it.
TEST(HandNode, FollowsOneRuleAfterAPauseOfAnyLength) {
    for (const std::string& scene : {press("", 10), grasp("", 10)})
        for (const Duration pause : {100ms, 300ms, 500ms, 3000ms, 5000ms}) {
            TwoNodes two(scene);
            two.start();
            two.run_for(700ms);
            EXPECT_EQ(two.hand.node->report().state, GripState::operating);
            two.links.set_carries([](const auto*) { return false; });
            two.run_for(pause);
            const bool was_safe = pause > 150ms;
            EXPECT_EQ(two.hand.node->report().state, was_safe ? GripState::safe : GripState::frozen);
            two.links.set_carries([](const auto*) { return true; });
            two.run_for(1500ms);
            const HandNode::Report report = two.hand.node->report();
            EXPECT_EQ(report.state, GripState::operating) << Milliseconds(pause).count();
            EXPECT_EQ(report.reason, "");
            EXPECT_EQ(report.safe_states, was_safe ? 1U : 0U);
            EXPECT_EQ(report.sessions, was_safe ? 2U : 1U);
        }
}

// The session is healthy, and its coprocessor learns so late.
TEST(HandNode, IsNotLatchedByWelcomesThatAreLost) {
    TwoNodes two(press());
    two.links.set_carries([](const proto::Envelope* message) { return !message || !message->has_answer(); });
    two.start();
    two.run_for(400ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    two.links.set_carries([](const auto*) { return true; });
    two.run_for(3s);
    EXPECT_GE(two.hand.node->report().sessions, 1U);
    EXPECT_EQ(two.hand.node->report().safe_states, 0U);
}

TEST(HandNode, WaitsForItsUserWhereTheSceneWantsThat) {
    TwoNodes two(press("", 10, "hand { rearm: BY_USER }"));
    two.start();
    two.hand.node->acknowledge();
    two.run_for(1500ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    EXPECT_EQ(two.hand.node->report().reason, "waits for the user's acknowledgement");
    EXPECT_EQ(two.hand.node->report().sessions, 1U) << "the session is in order";
    two.hand.node->acknowledge();
    two.run_for(10ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
    two.links.set_carries([](const auto*) { return false; });
    two.run_for(300ms);
    two.links.set_carries([](const auto*) { return true; });
    two.run_for(1s);
    EXPECT_EQ(two.hand.node->report().state, GripState::safe);
    EXPECT_EQ(two.hand.node->report().sessions, 2U);
    two.hand.node->acknowledge();
    two.run_for(10ms);
    EXPECT_EQ(two.hand.node->report().state, GripState::operating);
}

// Rows stop; or the pipe that they come from is closed.
TEST(HandNode, GoesSafeWhenTheSensorsFallSilent) {
    for (const bool closed : {false, true}) {
        TwoNodes two("duration_s: 10 link { tcp {} } source { standard_input {} }");
        two.start();
        ASSERT_NE(two.coprocessor.node->link_end().table(), nullptr);
        TableSource& table = *two.coprocessor.node->link_end().table();
        ASSERT_TRUE(table.feed("time_s,force_n\n"));
        for (int row = 0; row < 100; ++row) {
            ASSERT_TRUE(table.feed(std::to_string(0.005 * row) + ",6\n"));
            two.run_for(5ms);
        }
        EXPECT_EQ(two.hand.node->report().state, GripState::operating);
        const std::uint64_t told = two.hand.node->report().received.events;
        EXPECT_GT(told, 10U);
        if (closed) {
            EXPECT_TRUE(table.finish());
        }
        // The last row is of 0.495 s: its force is held for 60 ms, then it is unknown.
        two.run_for(300ms);
        EXPECT_EQ(two.hand.node->report().state, GripState::safe);
        EXPECT_EQ(two.hand.safe, std::vector<std::string>{"no samples from the sensors for 150 ms"});
        EXPECT_TRUE(all(between(two.hand.steps, 0.63, 0.79), gain_of, 0));
        EXPECT_GT(two.hand.node->report().received.unknown, 100ms);
        two.run_for(5s);
        EXPECT_LE(two.hand.node->report().received.events, told + 20) << "of forces that are only held";
        EXPECT_LT(two.hand.node->report().sessions, 25U) << "it is not hurried";
    }
}

TEST(HandNode, InLockstepKeepsItsSessionHoweverLongEachPacketTakes) {
    TwoNodes two(grasp());
    two.links.set_latency(5ms);
    two.start_in_lockstep();
    two.run_for(200ms);
    two.links.set_latency(200ms);
    two.run_to_the_end();
    EXPECT_EQ(two.hand.node->report().sessions, 1U);
    EXPECT_EQ(two.hand.node->failure(), std::nullopt);
    EXPECT_EQ(without_truth(two.hand.steps), without_truth(outcome_of_run(two.plan).steps));
}

// Held up just then for longer than it waits for a coprocessor.
TEST(HandNode, InLockstepNeedsNobodyOnceItHasBeenToldEverything) {
    TwoNodes two(press("connect_s: 0.1"));
    two.start_in_lockstep();
    const auto ended = [&] { return two.hand.last_of_session().find("has ended") != std::string::npos; };
    for (int turn = 0; turn < 100'000 && !ended(); ++turn) {
        two.hand.node->poll();
        two.coprocessor.node->poll();
        two.links.deliver();
    }
    ASSERT_TRUE(ended());
    EXPECT_LT(two.hand.node->at(), scene_start + 2s);
    two.now += 1s;
    two.run_to_the_end();
    EXPECT_EQ(two.hand.node->failure(), std::nullopt);
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_EQ(two.hand.node->at(), scene_start + 2s);
}

TEST(HandNode, InLockstepTellsHowFarItHasComeSoThatNobodyRunsAhead) {
    TwoNodes two(press());
    Duration ahead{};
    int told = 0;
    two.links.set_carries([&](const proto::Envelope* message) {
        told += message && message->has_clock();
        if (message && message->position() > 0)
            ahead = std::max(ahead, two.coprocessor.node->at() - two.hand.node->at());
        return true;
    });
    two.start({.lockstep = true}, {.lockstep = true});
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_GT(ahead, 0ms);
    EXPECT_LE(ahead, 210ms) << "a fifth of a second, and the time between two tellings";
    // Each end sends its clock 200 times a second: the coprocessor with each packet, the hand every 5 ms.
    EXPECT_LE(told, 820);
}

// A hand that has the samples sends its clock with each scan, however fast the scans come: if it waited 5 ms
// between two, as one without samples does, both ends would wait for each other for ever.
TEST(HandNode, InLockstepTellsOfEachScan) {
    TwoNodes two(grasp("packet_ms: 1 delivery_ms: 1", 1, "every_patch { sensor { rate_hz: 1000 } }"));
    two.start({.lockstep = true}, {.lockstep = true});
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 1000U);
    EXPECT_EQ(two.coprocessor.events, outcome_of_run(two.plan).events);
}

TEST(HandNode, InLockstepGivesUpOnACoprocessorThatDoesNotComeBack) {
    TwoNodes two(grasp("connect_s: 3"));
    two.links.set_latency(1ms);
    two.start_in_lockstep();
    two.run_for(100ms);
    const std::size_t done = two.hand.steps.size();
    EXPECT_GT(done, 10U);
    EXPECT_LT(done, 2000U);
    two.kill_coprocessor();
    two.run_for(2900ms);
    EXPECT_FALSE(two.hand.ended);
    EXPECT_LE(two.hand.steps.size(), done + 10) << "it waits";
    two.run_for(200ms);
    EXPECT_TRUE(two.hand.ended);
    EXPECT_EQ(two.hand.node->failure(), "the coprocessor has gone and has not come back in 3.000000 s");
}

TEST(HandNode, InLockstepGoesOnWithTheNextCoprocessor) {
    TwoNodes two(grasp());
    two.links.set_latency(1ms);
    two.start_in_lockstep();
    two.run_for(100ms);
    two.kill_coprocessor();
    two.run_for(1s);
    two.start_coprocessor({.lockstep = true});
    two.run_to_the_end();
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_EQ(two.hand.node->report().sessions, 2U);
    EXPECT_TRUE(two.hand.safe.empty()) << "time waits for the coprocessor";
}

TEST(HandNode, FailsWithItsSamplesAndSaysSo) {
    TwoNodes two(grasp("", 2,
                       "every_patch { sensor { full_scale_n: 0.1 out_of_range: REFUSE } } "
                       "gain { accept_unreachable_limit: true }"));
    two.start();
    two.run_for(1900ms);
    EXPECT_TRUE(two.hand.ended);
    ASSERT_TRUE(two.hand.node->failure());
    EXPECT_NE(two.hand.node->failure()->find("a force beyond full scale at "), std::string::npos)
        << *two.hand.node->failure();
    EXPECT_LT(two.hand.node->at(), scene_start + 1900ms);
}

TEST(HandNode, IsOfAPlanWithAController) {
    TwoNodes two(grasp());
    const Plan open_loop =
        make_plan(Scene::from_text(press("", 2, "record { events: true force: false picture: false }")));
    ASSERT_FALSE(open_loop.controller);
    const auto opened = HandNode::open(open_loop, two.links.listener(), {}, {}, [&] { return two.now; });
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().text.find("the plan has no controller"), std::string::npos)
        << opened.error().text;
}

class HandNodeRecording : public testing::Test {
  protected:
    HandNodeRecording()
        : file_(std::filesystem::temp_directory_path() /
                ("afferent-" + std::to_string(::getpid()) + ".node")) {}
    ~HandNodeRecording() override { std::filesystem::remove(file_); }

    Steps replayed() {
        Steps steps;
        Observer output;
        output.step = [&](const ControllerStep& step) { steps.push_back(numbers(step)); };
        const auto replay = value_or_throw(Replay::open(file_, std::move(output)));
        while (value_or_throw(replay->next())) replay->step();
        counts_ = replay->counts();
        EXPECT_TRUE(replay->closed());
        return steps;
    }

    std::filesystem::path file_;
    ReplayCounts counts_;
};

// A table that is wrong far behind its beginning: a loop that waits for no file has it read to its end
// before.
TEST_F(HandNodeRecording, OfATableIsReadBeforeALoopWithAThreadOfItsOwn) {
    {
        std::ofstream table(file_);
        table << "time_s,force_n\n";
        for (int row = 0; row < 50'000; ++row) table << row << ",1\n";
        table << "50000,one\n";
    }
    TwoNodes two("duration_s: 2 link { tcp {} } source { link { table { path: '" + file_.string() +
                 "' } } }");
    const auto opened = [&](const Plan& plan, bool grip_thread) {
        const auto node = HandNode::open(plan, two.links.listener(), {.grip_thread = grip_thread}, {},
                                         [&] { return two.now; });
        return node ? "opened" : node.error().text;
    };
    EXPECT_EQ(opened(two.plan, false), "opened");
    EXPECT_NE(opened(two.plan, true).find(":50002: column \"force_n\": \"one\" is not a number"),
              std::string::npos)
        << opened(two.plan, true);
    EXPECT_EQ(opened(TwoNodes(press()).plan, true), "opened") << "it has no table";
}

// A hand that starts over reads its tables again.
TEST_F(HandNodeRecording, OfATableThatIsGoneEndsTheHandThatStartsOver) {
    std::ofstream(file_) << "time_s,emg\n0,2048\n1,2048\n";
    TwoNodes two(press("", 2, "hand { emg_table { path: '" + file_.string() + "' } }"));
    two.start();
    two.run_for(500ms);
    two.kill_coprocessor();
    std::filesystem::remove(file_);
    two.start_coprocessor();
    two.run_for(1s);
    EXPECT_TRUE(two.hand.ended);
    ASSERT_TRUE(two.hand.node->failure());
    EXPECT_NE(two.hand.node->failure()->find(file_.string()), std::string::npos) << *two.hand.node->failure();
    EXPECT_EQ(two.hand.started_over, 0);
}

TEST_F(HandNodeRecording, ReplaysToTheSame) {
    TwoNodes two(grasp());
    two.start({.record = file_});
    two.run_to_the_end();
    EXPECT_TRUE(two.hand.node->close());
    EXPECT_EQ(two.hand.steps.size(), 2000U);
    EXPECT_EQ(replayed(), two.hand.steps);
    EXPECT_EQ(counts_.events, two.coprocessor.events.size());
}

// Late packets, stale packets, a cut, a safe state, another session.
TEST_F(HandNodeRecording, OfEverythingThatCanGoWrongReplaysToTheSame) {
    for (const std::string& scene : {grasp("", 6), press("", 6)}) {
        TwoNodes two(scene);
        two.start({.record = file_});
        two.run_for(400ms);
        two.links.set_latency(8ms);
        two.run_for(300ms);
        two.links.set_latency(120ms);
        two.run_for(300ms);
        two.links.set_carries([n = 0](const auto*) mutable { return ++n % 7 != 0; });
        two.links.set_latency(3ms);
        two.run_for(300ms);
        two.links.set_carries([](const auto*) { return false; });
        two.run_for(100ms);
        two.kill_coprocessor();
        two.links.set_carries([](const auto*) { return true; });
        two.run_for(2500ms);
        two.start_coprocessor();
        two.run_to_the_end();
        EXPECT_TRUE(two.hand.node->close());
        const HandNode::Report report = two.hand.node->report();
        EXPECT_EQ(without_truth(replayed()), without_truth(two.hand.steps));
        EXPECT_EQ(counts_.sessions, report.sessions);
        EXPECT_EQ(counts_.events, report.received.events);
        EXPECT_EQ(counts_.late, report.received.late);
        EXPECT_EQ(counts_.freezes, report.freezes);
        EXPECT_EQ(counts_.safe_states, report.safe_states);
        EXPECT_EQ(report.sessions, 2U);
        EXPECT_GT(report.received.late, 10U);
        EXPECT_GT(report.received.stale, 0U);
        EXPECT_GT(report.received.gaps, 2U);
        EXPECT_GT(report.safe_states, 0U);
    }
}

// Nothing of it reaches the loop or the recording, however much it sends before it is turned away.
TEST_F(HandNodeRecording, HoldsNothingOfASessionThatIsOutsideOfTheScene) {
    TwoNodes two(press());
    two.start({.record = file_});
    two.run_for(502ms);
    two.kill_coprocessor();
    const std::uint64_t heard = two.hand.node->report().received.events;
    two.run_for(1ms);
    // Its clock would be refused before.
    two.links.set_carries([](const proto::Envelope* message) { return !message || !message->has_echo(); });
    RawCoprocessor lost(two);
    two.run_for(1ms);
    Packetizer packetizer(packet_layout(two.plan));
    packetizer.begin_at(scene_start + 2100ms);
    for (Duration end = 2105ms; end <= 3600ms; end += 5ms) {
        packetizer.push(std::vector{Event{scene_start + end - 5ms, 0}});
        packetizer.close(scene_start + end, [&](const auto& packet) { lost.send(packet); });
    }
    two.run_for(20ms);
    EXPECT_NE(two.hand.last_of_session().find("outside of the scene"), std::string::npos)
        << two.hand.last_of_session();
    EXPECT_EQ(two.hand.node->report().dropped_packets, 0U);
    two.run_to_the_end();
    EXPECT_TRUE(two.hand.node->close());
    EXPECT_EQ(without_truth(replayed()), without_truth(two.hand.steps));
    EXPECT_EQ(counts_.sessions, 2U);
    EXPECT_EQ(counts_.events, heard);
    EXPECT_EQ(counts_.refused, 0U);
}

// Nothing in the packet itself is wrong: a replay that took it would be two seconds further.
TEST_F(HandNodeRecording, OfAPacketFromAheadOfItsTimeIsReplayedWithoutIt) {
    TwoNodes two(press());
    two.start_hand({.record = file_});
    RawCoprocessor coprocessor(two);
    two.run_for(10ms);
    Packetizer packetizer(packet_layout(two.plan));
    const auto press_until = [&](Duration end) {
        packetizer.push(std::vector{Event{scene_start + end - 5ms, 0}, Event{scene_start + end - 2ms, 1}});
        packetizer.close(scene_start + end, [&](const auto& packet) { coprocessor.send(packet); });
    };
    const auto press_for = [&](Duration begin, Duration end) {
        for (Duration at = begin + 5ms; at <= end; at += 5ms) {
            press_until(at);
            two.run_for(5ms);
        }
    };
    packetizer.begin_at(scene_start + 10ms);
    press_for(10ms, 500ms);
    packetizer.begin_at(scene_start + 1800ms);
    press_until(1805ms);
    two.run_for(5ms);
    packetizer.begin_at(scene_start + 505ms);
    press_for(505ms, 800ms);
    two.run_to_the_end();
    EXPECT_TRUE(two.hand.node->close());
    const HandNode::Report report = two.hand.node->report();
    EXPECT_EQ(report.received.refused, 1U);
    EXPECT_GT(report.received.events, 300U);
    EXPECT_EQ(without_truth(replayed()), without_truth(two.hand.steps));
    EXPECT_EQ(counts_.refused, 1U);
    EXPECT_EQ(counts_.events, report.received.events);
}

TEST_F(HandNodeRecording, ThatCannotBeWrittenIsRefusedAtOnce) {
    TwoNodes two(grasp());
    const auto opened = HandNode::open(two.plan, two.links.listener(), {.record = "/nowhere/at/all"}, {},
                                       [&] { return two.now; });
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().text.find("/nowhere/at/all"), std::string::npos) << opened.error().text;
}

}  // namespace
}  // namespace afferent
