// The loop that moves a hand, by itself and in virtual time: what it does with the input of its queues.
#include "afferent/nodes/grip_loop.hpp"

#include <gtest/gtest.h>

#include "afferent/io/wire/packet_receiver.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

Reception packet_of(TimePoint begin, TimePoint end, std::span<const Event> events = {}) {
    Reception reception;
    reception.known = {begin, end};
    reception.events = events;
    return reception;
}

class Loop {
  public:
    explicit Loop(const std::string& text) : plan(make_plan(Scene::from_text(text), Commands::wanted)) {
        auto side = HandSide::open(plan);
        EXPECT_TRUE(side);
        GripLoop::Options options;
        options.motor = [this](const ControllerStep& step) { commands.push_back(step); };
        options.fed = [this] { ++scans; };
        loop = std::make_unique<GripLoop>(plan, std::move(side.value()), std::move(options),
                                          [this] { return now; });
    }

    // Everything up to then, in the loop's own steps.
    void run_for(Duration most) {
        const MonotonicTime end = now + most;
        for (;;) {
            const MonotonicTime wake = loop->poll();
            if (now == end) return;
            now = std::min(wake, end);
        }
    }
    // A silent packet each 5 ms, without events.
    void hear_silence_for(Duration most) {
        for (const MonotonicTime end = now + most; now < end;) {
            run_for(5ms);
            const TimePoint known = scene_start + (now - began);
            loop->inbox().receive(packet_of(known - 5ms, known), {}, now);
            loop->inbox().packet({});
        }
    }
    void begin_session() {
        began = now;
        loop->inbox().opened(now, {});
        loop->inbox().begin(now, scene_start, nullptr);
    }
    GripState state() { return loop->report().state; }

    const Plan plan;
    MonotonicTime now = MonotonicTime(std::chrono::hours(1));
    MonotonicTime began;
    std::vector<ControllerStep> commands;
    std::uint64_t scans = 0;  // of which it has told
    std::unique_ptr<GripLoop> loop;
};

TEST(GripLoop, IsSafeAndDoesNothingBeforeTheFirstSession) {
    Loop it(reach());
    EXPECT_EQ(it.state(), GripState::safe);
    it.run_for(1s);
    EXPECT_TRUE(it.commands.empty());
    EXPECT_EQ(it.loop->poll(), MonotonicTime::max());
}

TEST(GripLoop, OperatesOncePacketsHaveComeForTheFreezeThreshold) {
    Loop it(reach());
    it.begin_session();
    it.run_for(20ms);
    EXPECT_EQ(it.state(), GripState::safe) << "a session by itself changes nothing";
    it.hear_silence_for(30ms);
    EXPECT_EQ(it.state(), GripState::safe);
    it.hear_silence_for(20ms);
    EXPECT_EQ(it.state(), GripState::operating);
}

TEST(GripLoop, StepsToTheScenesEndWithoutAnySession) {
    Loop it(reach());
    it.begin_session();
    it.hear_silence_for(100ms);
    it.loop->inbox().ended(it.now, std::nullopt);
    it.run_for(3s);
    ASSERT_EQ(it.commands.size(), 2000U);
    for (std::size_t k = 0; k < it.commands.size(); ++k)
        ASSERT_EQ(it.commands[k].time, scene_start + static_cast<int>(k) * 1ms);
    EXPECT_TRUE(it.loop->report().at_end);
    EXPECT_EQ(it.state(), GripState::safe);
    EXPECT_EQ(it.commands.back().command, 0);
}

TEST(GripLoop, ActsOnAStateBeforeAnybodyHearsOfIt) {
    Loop it(reach("safe_state: OPEN"));
    it.begin_session();
    it.hear_silence_for(500ms);
    EXPECT_GT(it.commands.back().command, 0);
    it.run_for(200ms);
    EXPECT_EQ(it.commands.back().command, -0.5) << "nobody has taken a record";
}

// Nobody takes records or scans, as when a terminal, a disk or a socket blocks.
TEST(GripLoop, WaitsForNobodyAndCountsWhatFoundNoRoom) {
    Loop it(grasp("", 20));
    it.begin_session();
    it.run_for(19s);
    EXPECT_EQ(it.commands.size(), 19'001U);
    const GripReport& report = it.loop->report();
    EXPECT_GT(report.lost_steps, 10'000U);
    EXPECT_GT(report.dropped_scans, 1'000U);
    std::uint64_t written = 0;
    HandWriter::Listener listener;
    listener.step = [&](const auto&) { ++written; };
    HandWriter writer({}, listener);
    writer.write(it.loop->records());
    EXPECT_EQ(written + report.lost_steps, 19'001U);
}

TEST(GripLoop, TellsOfEachScanOnceItIsThere) {
    Loop it(grasp("", 20));
    it.begin_session();
    std::uint64_t taken = 0;
    for (int k = 0; k < 100; ++k) {
        it.run_for(5ms);
        for (; it.loop->scans().next(); it.loop->scans().pop()) ++taken;
        EXPECT_EQ(taken, it.scans);
    }
    EXPECT_GT(taken, 50U);
}

TEST(GripInbox, TakesPacketsThatFoundNoRoomForAGap) {
    GripInbox inbox(4, false);
    const auto span = [](int k) { return TimeSpan{scene_start + k * 5ms, scene_start + (k + 1) * 5ms}; };
    const auto receive = [&](int k) {
        inbox.receive(packet_of(span(k).begin, span(k).end), {}, MonotonicTime());
        inbox.packet({});
    };
    const auto take = [&] {
        EXPECT_NE(inbox.next(), nullptr);
        GripInput taken;
        std::swap(taken, *inbox.next());
        inbox.pop();
        return taken;
    };
    for (int k = 0; k < 10; ++k) receive(k);
    EXPECT_EQ(inbox.dropped(), 6U);
    // The beginning and the end of a session pass all the same.
    inbox.acknowledged(MonotonicTime());
    for (int k = 0; k < 4; ++k) {
        const GripInput taken = take();
        EXPECT_EQ(taken.reception.known, span(k));
        EXPECT_EQ(taken.reception.gap, std::nullopt);
    }
    EXPECT_EQ(take().kind, GripInput::Kind::acknowledged);
    receive(10);
    EXPECT_EQ(take().reception.gap, (TimeSpan{span(4).begin, span(9).end}));
    receive(11);
    EXPECT_EQ(take().reception.gap, std::nullopt) << "it is told once";
    EXPECT_EQ(inbox.next(), nullptr);
}

TEST(GripInbox, NeverLosesASessionsBeginAndEnd) {
    GripInbox inbox(4, false);
    for (int k = 0; k < 20; ++k) inbox.opened(MonotonicTime(), {});
    inbox.stop();
    int taken = 0;
    bool stopped = false;
    for (int i = 0; i < 3; ++i, inbox.flush())
        for (; const GripInput* input = inbox.next(); inbox.pop(), ++taken)
            stopped = input->kind == GripInput::Kind::stop;
    EXPECT_EQ(taken, 21);
    EXPECT_TRUE(stopped) << "and keeps their order";
}

TEST(GripLoop, MeasuresHowLateItsStepsRun) {
    Loop it(press());
    it.begin_session();
    for (int k = 0; k < 1000; ++k) {
        it.now += k % 50 == 0 ? 5ms : 1ms;
        it.loop->poll();
    }
    it.loop->inbox().stop();
    it.loop->poll();
    const GripReport::Lateness& late = it.loop->report().step_lateness;
    EXPECT_LT(late.p50, 100us);
    EXPECT_GE(late.p99, 3ms);
    EXPECT_EQ(late.max, 5ms);
}

}  // namespace
}  // namespace afferent
