// One fault at a time: what happens to the hand, and that it works again afterwards. The safety property is
// asserted in each.
#include <gtest/gtest.h>

#include <string>

#include "afferent/io/wire/packetizer.hpp"
#include "tests/faults/faulty_nodes.hpp"
#include "tests/faults/hostile_messages.hpp"
#include "tests/long_runs.hpp"

namespace afferent {
namespace {

// Longer than any silence that matters, and than the coprocessor needs to open the next session.
constexpr Duration a_while = 3s;

class Faults : public testing::TestWithParam<NetworkKind> {
  protected:
    FaultyNodes& open(const std::string& scene) {
        nodes_ = std::make_unique<FaultyNodes>(scene, GetParam());
        nodes_->run_for(1s);
        EXPECT_EQ(state(), GripState::operating) << nodes_->hand()->report().reason;
        return *nodes_;
    }
    FaultyNodes& open_unfit(const std::string& scene) {
        nodes_ = std::make_unique<FaultyNodes>(scene, GetParam());
        return *nodes_;
    }
    void TearDown() override {
        if (!nodes_) return;
        for (const std::string& violation : nodes_->property().violations()) ADD_FAILURE() << violation;
    }
    GripState state() { return nodes_->hand()->report().state; }
    bool closes() { return nodes_->property().closes(); }
    void expect_recovery() {
        if (!nodes_->coprocessor()) nodes_->start_coprocessor();
        nodes_->run_for(a_while);
        EXPECT_EQ(state(), GripState::operating) << nodes_->hand()->report().reason;
        EXPECT_TRUE(closes());
    }

  private:
    std::unique_ptr<FaultyNodes> nodes_;
};

TEST_P(Faults, AHandThatNobodyHasVisitedIsSafe) {
    FaultyNodes& nodes = open_unfit(reaching());
    nodes.kill_coprocessor();
    nodes.run_for(a_while);
    EXPECT_EQ(state(), GripState::safe);
    EXPECT_FALSE(closes());
    expect_recovery();
}

TEST_P(Faults, ByesWithoutAHelloChangeNothing) {
    for (const auto reason : {proto::END_OF_SCENE, proto::INTERRUPTED, proto::FAILURE}) {
        FaultyNodes& nodes = open(reaching());
        nodes.kill_coprocessor();
        nodes.run_for(a_while);
        EXPECT_EQ(state(), GripState::safe);
        for (int i = 0; i < 3; ++i) {
            const Stranger stranger(nodes.network, {bye_message(reason)});
            nodes.run_for(500ms);
            EXPECT_EQ(state(), GripState::safe);
        }
        expect_recovery();
        TearDown();
    }
}

TEST_P(Faults, ByesAfterAStrangersHelloChangeNothing) {
    for (const auto reason : {proto::END_OF_SCENE, proto::INTERRUPTED, proto::FAILURE}) {
        FaultyNodes& nodes = open(reaching());
        nodes.kill_coprocessor();
        nodes.run_for(a_while);
        {
            Stranger stranger(nodes.network, {hello_of(nodes.plan())});
            nodes.run_for(20ms);
            stranger.say(bye_message(reason));
            nodes.run_for(500ms);
            EXPECT_EQ(state(), GripState::safe);
        }
        expect_recovery();
        TearDown();
    }
}

TEST_P(Faults, AnEarlyEndOfTheSceneMakesSafe) {
    FaultyNodes& nodes = open(reaching());
    nodes.network.inject(bye_message(proto::END_OF_SCENE, 1s));
    nodes.kill_coprocessor();
    nodes.run_for(100ms);
    EXPECT_EQ(state(), GripState::frozen);
    nodes.run_for(a_while);
    EXPECT_EQ(state(), GripState::safe);
    expect_recovery();
}

TEST_P(Faults, AnInterruptedCoprocessorMakesSafeAndTheNextOneReArms) {
    FaultyNodes& nodes = open(reaching());
    nodes.coprocessor()->interrupt();
    nodes.run_for(20ms);
    nodes.kill_coprocessor();
    nodes.run_for(a_while);
    EXPECT_EQ(state(), GripState::safe);
    expect_recovery();
}

TEST_P(Faults, ASessionThatEndsInItsHandshakeChangesNothing) {
    FaultyNodes& nodes = open(reaching());
    nodes.kill_coprocessor();
    nodes.run_for(a_while);
    proto::Envelope other_tick = hello_of(nodes.plan());
    other_tick.mutable_hello()->set_tick_us(123);
    for (int i = 0; i < 3; ++i) {
        const Stranger stranger(nodes.network, {i == 1 ? hello_of(nodes.plan(), false) : other_tick});
        nodes.run_for(a_while);
        EXPECT_EQ(state(), GripState::safe);
    }
    expect_recovery();
}

TEST_P(Faults, StepsGoOnWhereTheNextCoprocessorSaysNothing) {
    FaultyNodes& nodes = open(fed());
    nodes.kill_coprocessor();
    nodes.run_for(20ms);
    const Stranger stranger(nodes.network, {hello_of(nodes.plan())});
    nodes.run_for(a_while);
    EXPECT_EQ(state(), GripState::safe);
    EXPECT_FALSE(closes());
}

TEST_P(Faults, ClocksThatDriftStayTogether) {
    for (const double ppm : {100., -100.}) {
        FaultyNodes& nodes = open(reaching());
        nodes.drift(ppm);
        nodes.run_for(Duration(long_runs ? 10min : 2min));
        const HandNode::Report report = nodes.hand()->report();
        EXPECT_EQ(report.received.stale, 0U);
        EXPECT_EQ(report.sessions, 1U);
        EXPECT_EQ(report.state, GripState::operating) << report.reason;
        TearDown();
    }
}

TEST_P(Faults, APacketFarAheadIsRefusedAndEndsNothing) {
    FaultyNodes& nodes = open(reaching());
    Packetizer packetizer(packet_layout(nodes.plan()));
    const TimePoint ahead = scene_start + (nodes.hand()->at() + 2s - scene_start) / 5ms * 5ms;
    packetizer.begin_at(ahead - 5ms);
    packetizer.push(std::vector{Event{ahead - 1ms, 0}});
    packetizer.close(ahead, [&](const proto::Envelope& packet) { nodes.network.inject(packet); });
    nodes.run_for(20ms);
    const HandNode::Report report = nodes.hand()->report();
    EXPECT_EQ(report.received.refused, 1U);
    EXPECT_EQ(report.sessions, 1U);
    EXPECT_EQ(report.broken_sessions, 0U);
    EXPECT_EQ(report.state, GripState::operating) << report.reason;
    EXPECT_EQ(nodes.hand()->failure(), std::nullopt);
    expect_recovery();
}

TEST_P(Faults, ALinkThatIsSlowFromItsBeginIsKnownToBe) {
    FaultyNodes& nodes = open_unfit(reaching());
    nodes.network.fate = [](const auto&, FaultyNetwork::Side) { return FaultyNetwork::Fate{.delay = 115ms}; };
    nodes.run_for(10s);
    EXPECT_NE(state(), GripState::operating);
    EXPECT_FALSE(closes());
    nodes.network.fate = [](const auto&, FaultyNetwork::Side) { return FaultyNetwork::Fate{}; };
    nodes.kill_coprocessor();
    expect_recovery();
}

// The coprocessor began behind the hand's clock by the delay of its first message, and stays there.
TEST_P(Faults, ASlowBeginIsForgottenWithTheNextSession) {
    FaultyNodes& nodes = open_unfit(reaching());
    nodes.network.fate = [](const auto&, FaultyNetwork::Side) { return FaultyNetwork::Fate{.delay = 115ms}; };
    nodes.run_for(1s);
    nodes.network.fate = [](const auto&, FaultyNetwork::Side) { return FaultyNetwork::Fate{}; };
    expect_recovery();
}

TEST_P(Faults, APauseOfBothProcessesEndsByTheSameRuleHoweverLongItIs) {
    for (const Duration pause : {30ms, 100ms, 500ms, 3000ms}) {
        FaultyNodes& nodes = open(reaching());
        nodes.stop(FaultyNetwork::hand, true);
        nodes.stop(FaultyNetwork::coprocessor, true);
        nodes.run_for(pause);
        nodes.stop(FaultyNetwork::hand, false);
        nodes.stop(FaultyNetwork::coprocessor, false);
        expect_recovery();
        TearDown();
    }
}

TEST_P(Faults, APauseOfOneProcessEndsByTheSameRule) {
    for (const auto link_end : {FaultyNetwork::hand, FaultyNetwork::coprocessor})
        for (const Duration pause : {30ms, 100ms, 500ms, 3000ms}) {
            FaultyNodes& nodes = open(reaching());
            nodes.stop(link_end, true);
            nodes.run_for(pause);
            nodes.stop(link_end, false);
            expect_recovery();
            TearDown();
        }
}

TEST_P(Faults, WelcomesThatAreLostLatchNothing) {
    FaultyNodes& nodes = open_unfit(reaching());
    nodes.network.fate = [lost = 0](const proto::Envelope& message, FaultyNetwork::Side) mutable {
        const bool is_lost = message.has_answer() && lost < 2;
        lost += is_lost ? 1 : 0;
        return FaultyNetwork::Fate{.copies = is_lost ? 0U : 1U};
    };
    nodes.run_for(1s);
    EXPECT_EQ(state(), GripState::operating) << nodes.hand()->report().reason;
    expect_recovery();
}

TEST_P(Faults, SensorsThatFallSilentMakeSafe) {
    FaultyNodes& nodes = open(fed());
    nodes.silence_sensors(true);
    nodes.run_for(a_while);
    EXPECT_EQ(state(), GripState::safe);
    EXPECT_FALSE(closes());
    nodes.silence_sensors(false);
    expect_recovery();
}

TEST_P(Faults, ACableThatIsOutDeliversNothingThatIsOld) {
    for (const Duration out : {40ms, 100ms, 400ms, 2000ms}) {
        FaultyNodes& nodes = open(reaching());
        nodes.network.cut(true);
        nodes.run_for(out);
        nodes.network.cut(false);
        expect_recovery();
        TearDown();
    }
}

// A stream keeps them in order.
TEST_P(Faults, PacketsThatOvertakeEachOtherAreNotLost) {
    FaultyNodes& nodes = open(reaching());
    nodes.network.fate = [sent = 0](const auto&, FaultyNetwork::Side) mutable {
        return FaultyNetwork::Fate{.delay = ++sent % 3 == 0 ? 6ms : 5ms};
    };
    nodes.run_for(a_while);
    const PacketCounts& received = nodes.hand()->report().received;
    EXPECT_GT(received.packets, 100U);
    EXPECT_EQ(received.gaps, 0U);
    EXPECT_EQ(received.out_of_order + received.lost_events, 0U);
    expect_recovery();
}

INSTANTIATE_TEST_SUITE_P(Over, Faults, testing::Values(NetworkKind::stream, NetworkKind::datagrams),
                         [](const auto& which) {
                             return which.param == NetworkKind::stream ? "Stream" : "Datagrams";
                         });

}  // namespace
}  // namespace afferent
