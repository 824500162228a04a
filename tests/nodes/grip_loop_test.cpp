// The loop that moves a hand, by itself and in virtual time: what it does with the input of its queues.
#include "afferent/nodes/grip_loop.hpp"

#include <gtest/gtest.h>

#include "afferent/io/wire/packet_receiver.hpp"
#include "tests/nodes/two_nodes.hpp"
#include "tests/value_or_throw.hpp"

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
    explicit Loop(const std::string& text, GripLoop::Options options = {})
        : plan(make_plan(Scene::from_text(text), Commands::wanted)) {
        options.motor = [this](const ControllerStep& step) { commands.push_back(step); };
        options.fed = [this] { ++scans; };
        loop = std::make_unique<GripLoop>(plan, value_or_throw(HandEnd::open(plan)), std::move(options),
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
    const ControllerStep& last_command() const { return commands.at(commands.size() - 1); }
    // Of the records that wait, which are taken.
    std::vector<HandRecord::Kind> recorded() {
        std::vector<HandRecord::Kind> kinds;
        for (; const HandRecord* record = loop->records().next(); loop->records().pop())
            kinds.push_back(record->kind);
        return kinds;
    }

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
    EXPECT_EQ(it.last_command().command, 0);
}

TEST(GripLoop, ActsOnAStateBeforeAnybodyHearsOfIt) {
    Loop it(reach("safe_state: OPEN"));
    it.begin_session();
    it.hear_silence_for(500ms);
    EXPECT_GT(it.last_command().command, 0);
    it.run_for(200ms);
    EXPECT_EQ(it.last_command().command, -0.5) << "nobody has taken a record";
}

TEST(GripLoop, TellsWhoPollsItOfEachThingThatItHasDone) {
    Loop it(reach());
    it.begin_session();
    it.loop->poll();
    const std::size_t before = it.commands.size();
    it.now += 10ms;
    std::vector<std::size_t> done;
    it.loop->poll([&] { done.push_back(it.commands.size() - before); });
    ASSERT_EQ(it.commands.size() - before, 10U);
    for (std::size_t step = 1; step <= 10; ++step)
        EXPECT_NE(std::ranges::find(done, step), done.end()) << "nobody was told after step " << step;
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
    Observer listener;
    listener.step = [&](const auto&) { ++written; };
    HandWriter writer({}, listener);
    writer.write(it.loop->records());
    EXPECT_EQ(written + report.lost_steps, 19'001U);
}

TEST(GripLoop, GoesOnWhereNothingCanBeRecorded) {
    Loop it(grasp("", 20), {.keeps_messages = true});
    it.begin_session();
    it.run_for(10s);
    const std::uint64_t lost = it.loop->report().lost_steps;
    EXPECT_GT(lost, 5000U);
    it.loop->inbox().opened(it.now, {});
    it.hear_silence_for(100ms);
    EXPECT_EQ(it.state(), GripState::operating);
    it.loop->inbox().ended(it.now, proto::Bye());
    it.run_for(100ms);
    EXPECT_EQ(it.state(), GripState::frozen);
    EXPECT_EQ(it.loop->report().lost_steps, lost + 200);
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

TEST(GripLoop, TellsOfItsInputAtOnce) {
    Loop it(reach());
    it.begin_session();
    EXPECT_FALSE(it.loop->report().begun);
    it.loop->take_inputs();
    EXPECT_TRUE(it.loop->report().begun);
    EXPECT_FALSE(it.loop->report().stopped);
    it.loop->inbox().stop();
    it.loop->take_inputs();
    EXPECT_TRUE(it.loop->report().stopped);
}

TEST(GripLoop, DoesNothingOnceItIsStopped) {
    Loop it(reach());
    it.begin_session();
    it.run_for(10ms);
    EXPECT_EQ(it.commands.size(), 11U);
    it.loop->inbox().stop();
    it.run_for(100ms);
    EXPECT_EQ(it.commands.size(), 11U);
    EXPECT_EQ(it.loop->poll(), MonotonicTime::max());
}

// By 2000 ppm at most: four milliseconds in two seconds.
TEST(GripLoop, IsSteeredOnceItHasBegun) {
    Loop it(grasp("", 20));
    it.loop->inbox().steer(it.now, 1s);
    it.run_for(10ms);
    EXPECT_TRUE(it.commands.empty());
    EXPECT_FALSE(it.loop->report().pacer);
    it.begin_session();
    it.loop->inbox().steer(it.now, 1s);
    it.run_for(2s);
    ASSERT_TRUE(it.loop->report().pacer);
    EXPECT_EQ(it.loop->report().pacer->scene_time(it.now), scene_start + 2004ms);
    EXPECT_EQ(it.last_command().time, scene_start + 2004ms);
}

TEST(GripLoop, RecordsTheMessagesThatItIsGiven) {
    using Kind = HandRecord::Kind;
    Loop it(reach(), {.keeps_messages = true});
    EXPECT_EQ(it.recorded(), std::vector{Kind::grip_state});
    it.begin_session();
    it.loop->inbox().receive(packet_of(scene_start, scene_start + 5ms), {}, it.now);
    it.loop->inbox().packet({});
    it.loop->inbox().packet({});  // of which nothing was received
    it.loop->inbox().ended(it.now, proto::Bye());
    it.loop->take_inputs();
    std::vector<std::pair<Kind, bool>> told;  // and whether it was refused
    for (; const HandRecord* record = it.loop->records().next(); it.loop->records().pop())
        told.emplace_back(record->kind, record->refused);
    EXPECT_EQ(told, (std::vector<std::pair<Kind, bool>>{{Kind::hello, false},
                                                        {Kind::begin, false},
                                                        {Kind::packet, false},
                                                        {Kind::packet, true},
                                                        {Kind::bye, false}}));
    it.loop->inbox().opened(it.now, {});
    it.loop->inbox().ended(it.now, std::nullopt);
    it.loop->take_inputs();
    EXPECT_EQ(it.recorded(), std::vector{Kind::hello}) << "it broke off, without a bye";
    Loop forgetful(reach());
    forgetful.begin_session();
    forgetful.loop->inbox().receive(packet_of(scene_start, scene_start + 5ms), {}, forgetful.now);
    forgetful.loop->inbox().packet({});
    forgetful.loop->take_inputs();
    EXPECT_EQ(forgetful.recorded(), (std::vector{Kind::grip_state, Kind::hello, Kind::begin}));
}

TEST(GripLoop, RecordsWhereASessionBeginsAndWhereItGoesOn) {
    Loop it(reach());
    it.begin_session();
    it.run_for(10ms);
    it.loop->inbox().opened(it.now, {});
    it.loop->inbox().restart(it.now);
    it.loop->take_inputs();
    std::vector<std::pair<bool, TimePoint>> begun;
    for (; const HandRecord* record = it.loop->records().next(); it.loop->records().pop())
        if (record->kind == HandRecord::Kind::begin) begun.emplace_back(record->new_hand, record->time);
    EXPECT_EQ(begun,
              (std::vector<std::pair<bool, TimePoint>>{{true, scene_start}, {false, scene_start + 10ms}}));
}

TEST(GripLoop, StepsOnWithoutSamplesThatItCannotTake) {
    Loop it(grasp("", 2,
                  "every_patch { sensor { full_scale_n: 0.1 out_of_range: REFUSE } } "
                  "gain { accept_unreachable_limit: true }"));
    it.begin_session();
    EXPECT_EQ(it.loop->failure(), std::nullopt);
    it.hear_silence_for(1900ms);
    const auto failure = it.loop->failure();
    ASSERT_TRUE(failure);
    EXPECT_NE(failure->find("a force beyond full scale at "), std::string::npos) << *failure;
    const std::uint64_t scans = it.scans;
    it.run_for(1s);
    EXPECT_EQ(it.scans, scans);
    EXPECT_EQ(it.loop->failure(), failure) << "no sample has been taken since";
    EXPECT_EQ(it.commands.size(), 2000U);
    EXPECT_TRUE(it.loop->report().at_end);
}

TEST(GripLoop, DropsNoPacketInLockstep) {
    Loop it(press(), {.lockstep = true});
    it.begin_session();
    for (int k = 0; k < 200; ++k) {
        it.loop->inbox().receive(packet_of(scene_start + k * 5ms, scene_start + (k + 1) * 5ms), {}, it.now);
        it.loop->inbox().packet({});
        it.loop->take_inputs();
    }
    EXPECT_EQ(it.loop->report().dropped_packets, 0U);
    EXPECT_EQ(it.state(), GripState::operating) << "time waits for the coprocessor";
    it.loop->allow(scene_start + 10ms);
    it.loop->poll();
    EXPECT_EQ(it.commands.size(), 11U);
    EXPECT_EQ(it.state(), GripState::operating);
    it.loop->inbox().stop();
    it.loop->take_inputs();
    EXPECT_FALSE(it.loop->report().pacer);
    EXPECT_EQ(it.loop->report().step_lateness.max, 0ms) << "in virtual time nothing is late";
}

// The last part of a span that was thought to be known.
TEST(GripLoop, KnowsLessWhereAPacketTellsThatSomethingBeforeItIsMissing) {
    double sigma_n[2];
    for (const bool missing : {false, true}) {
        Loop it(press());
        it.begin_session();
        it.hear_silence_for(100ms);
        it.run_for(5ms);
        Reception reception = packet_of(scene_start + 100ms, scene_start + 105ms);
        if (missing) reception.gap = TimeSpan{scene_start + 50ms, scene_start + 100ms};
        it.loop->inbox().receive(reception, {}, it.now);
        it.loop->inbox().packet({});
        it.run_for(6ms);
        sigma_n[missing] = it.last_command().estimate.sigma_n;
    }
    EXPECT_GT(sigma_n[true], 1.5 * sigma_n[false]);
}

// The 128 packets that wait to act leave no room for others.
TEST(GripLoop, TakesPacketsThatFindNoRoomForAGap) {
    const auto span = [](int k) { return TimeSpan{scene_start + k * 5ms, scene_start + (k + 1) * 5ms}; };
    const auto steps_of = [&](Loop& it, int packets, const std::optional<TimeSpan>& gap, bool new_session) {
        it.begin_session();
        const auto receive = [&](int k, const std::optional<TimeSpan>& gap_before) {
            const std::vector<Event> events{{span(k).begin, 0}};
            Reception reception = packet_of(span(k).begin, span(k).end, events);
            reception.gap = gap_before;
            it.loop->inbox().receive(reception, {}, it.now);
            it.loop->inbox().packet({});
            it.loop->take_inputs();
        };
        for (int k = 0; k < packets; ++k) receive(k, std::nullopt);
        it.run_for(1100ms);
        if (new_session) it.loop->inbox().opened(it.now, {});
        receive(200, gap);
        it.run_for(100ms);
        Steps steps;
        for (const ControllerStep& step : it.commands) steps.push_back(numbers(step));
        return steps;
    };
    Loop dropping(press());
    const Steps dropped = steps_of(dropping, 200, std::nullopt, false);
    EXPECT_EQ(dropping.loop->report().dropped_packets, 72U);
    Loop told(press());
    const Steps of_a_gap = steps_of(told, 128, TimeSpan{span(128).begin, span(199).end}, false);
    EXPECT_EQ(told.loop->report().dropped_packets, 0U);
    EXPECT_EQ(dropped, of_a_gap);
    Loop forgetting(press());
    Loop silent(press());
    EXPECT_EQ(steps_of(forgetting, 200, std::nullopt, true), steps_of(silent, 128, std::nullopt, true))
        << "another session has lost nothing yet";
}

TEST(GripLoop, KeepsTheScansOfHalfASecond) {
    Loop it(grasp("", 20));
    it.begin_session();
    it.run_for(500ms);
    EXPECT_EQ(it.loop->report().dropped_scans, 0U);
    std::uint64_t kept = 0;
    for (; it.loop->scans().next(); it.loop->scans().pop()) ++kept;
    EXPECT_EQ(kept, it.scans);
    EXPECT_GT(kept, 90U);
}

// As a bye does that tells how much was lost.
TEST(GripLoop, TakesAGapAloneForNoSignOfLife) {
    Loop it(reach());
    it.begin_session();
    it.hear_silence_for(100ms);
    ASSERT_EQ(it.state(), GripState::operating);
    for (int k = 0; k < 14; ++k) {
        EXPECT_EQ(it.state(), k < 12 ? GripState::operating : GripState::frozen) << k;
        it.run_for(5ms);
        const TimePoint known = scene_start + (it.now - it.began);
        Reception reception = packet_of(known, known);
        reception.gap = TimeSpan{known - 5ms, known};
        it.loop->inbox().receive(reception, {}, it.now);
        it.loop->inbox().packet({});
    }
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

// Quantiles cost time: they are computed every 256 steps, and at the end.
TEST(GripLoop, TellsHowLateItsStepsRunNowAndThenAndAtTheEnd) {
    const auto late_by = [](Loop& it, Duration lag) {
        it.now += lag;
        it.loop->poll();
    };
    Loop running(grasp("", 20));
    running.begin_session();
    running.run_for(100ms);
    late_by(running, 5ms);
    running.run_for(100ms);
    EXPECT_EQ(running.loop->report().step_lateness.max, 0ms) << "not yet";
    running.run_for(100ms);
    EXPECT_EQ(running.loop->report().step_lateness.max, 4ms) << "the first of five, a millisecond later";
    Loop stopped(grasp("", 20));
    stopped.begin_session();
    stopped.run_for(10ms);
    late_by(stopped, 5ms);
    stopped.loop->inbox().stop();
    stopped.loop->take_inputs();
    EXPECT_EQ(stopped.loop->report().step_lateness.max, 4ms);
    Loop ended(reach());
    ended.begin_session();
    ended.run_for(1900ms);
    late_by(ended, 5ms);
    ended.run_for(90ms);
    EXPECT_EQ(ended.loop->report().step_lateness.max, 0ms) << "not yet";
    ended.run_for(10ms);
    EXPECT_TRUE(ended.loop->report().at_end);
    EXPECT_EQ(ended.loop->report().step_lateness.max, 4ms);
}

// It acts before the next step, which is soon enough.
TEST(GripLoop, CountsNoPacketAsADeadline) {
    const auto missed = [](bool with_packets) {
        Loop it(press("delivery_ms: 5"));
        it.begin_session();
        it.run_for(1ms);
        for (int k = 0; with_packets && k < 4; ++k)
            it.loop->inbox().receive(packet_of(scene_start + k * 1ms, scene_start + (k + 1) * 1ms), {},
                                     it.now);
        it.now += 15ms;
        it.loop->poll();
        return it.loop->report().pacer.value().missed_deadlines();
    };
    EXPECT_GT(missed(false), 10U);
    EXPECT_EQ(missed(true), missed(false));
}

}  // namespace
}  // namespace afferent
