// What a node says of itself while it runs, and a run once it is over.
#include "afferent/nodes/run_summary.hpp"

#include <gtest/gtest.h>

#include "afferent/nodes/chip_reader.hpp"
#include "afferent/nodes/output_thread.hpp"
#include "afferent/nodes/replay.hpp"
#include "tests/counts_nothing.hpp"
#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

std::string text(Summary summary, const char* key) {
    const std::string* const found = summary[key].text();
    return found ? *found : "";
}

bool interrupted(Summary summary) { return std::get<bool>(summary["interrupted"].value()); }

TEST(Reports, CountFromNothing) {
    EXPECT_TRUE(counts_nothing<ChipComparison::Counts>());
    EXPECT_TRUE(counts_nothing<ReplayCounts>());
    EXPECT_TRUE(counts_nothing<LinkTotals>());
    EXPECT_TRUE(counts_nothing<OutputLosses>());
    EXPECT_TRUE(counts_nothing<CoprocessorNode::Report::Counts>());
    const ChipReport chip;
    for (const std::uint64_t count : {chip.refused_bytes, chip.packets, chip.refused_packets,
                                      chip.unknown_packets, chip.implausible_packets, chip.gaps,
                                      chip.lost_events, chip.late_events, chip.beginnings, chip.clock_jumps})
        EXPECT_EQ(count, 0U);
    EXPECT_EQ(chip.clock_ppm, 0);
    const CoprocessorNode::Report coprocessor;
    for (const std::uint64_t count :
         {coprocessor.sessions, coprocessor.broken_sessions, coprocessor.interrupted_sessions})
        EXPECT_EQ(count, 0U);
    EXPECT_EQ(coprocessor.times_begun, 1U);
    const HandNode::Report hand;
    for (const std::uint64_t count :
         {hand.sessions, hand.broken_sessions, hand.interrupted_sessions, hand.refused_peers, hand.feed_bytes,
          hand.freezes, hand.safe_states, hand.dropped_packets, hand.dropped_scans, hand.unwritten_steps,
          hand.lost_events})
        EXPECT_EQ(count, 0U);
    EXPECT_FALSE(hand.real_time_priority);
    const HandReadings device;
    for (const std::uint64_t count :
         {device.commands, device.replies, device.unanswered, device.refused_frames, device.lost_lines,
          device.implausible_replies, device.zeros_taken, device.zeros_refused,
          std::uint64_t{device.motor_count}, std::uint64_t{device.sensor_count},
          std::uint64_t{device.temperature_status}})
        EXPECT_EQ(count, 0U);
    EXPECT_FALSE(device.answering || device.driven);
    EXPECT_EQ(device.motors[0].position_deg, 0);
    EXPECT_EQ(device.motors[0].current_a, 0);
    EXPECT_EQ(DeviceCommand().command, 0);
    const GripReport grip;
    for (const std::uint64_t count :
         {grip.next_step, grip.sessions, grip.freezes, grip.safe_states, grip.late_packets,
          grip.dropped_packets, grip.dropped_scans, grip.lost_steps})
        EXPECT_EQ(count, 0U);
    EXPECT_FALSE(grip.begun || grip.at_end || grip.stopped || grip.spent);
}

TEST(StatusOf, ANodeSaysHowItsSessionAndTheGripStand) {
    TwoNodes two(press("", 20));
    two.start();
    two.run_for(1s);
    Summary ours = status_of(*two.coprocessor.node);
    EXPECT_EQ(text(ours, "session"), "open");
    EXPECT_EQ(ours["sessions"].number(), 1);
    EXPECT_EQ(ours.find("last_refusal"), nullptr) << "nothing was refused";
    EXPECT_GT(ours["bytes"].number(), 100) << "of the session that is open, too";
    EXPECT_EQ(text(status_of(*two.hand.node), "grip_state"), "operating");
    two.kill_coprocessor();
    two.run_for(80ms);
    EXPECT_EQ(text(status_of(*two.hand.node), "grip_state"), "frozen");
    two.run_for(100ms);
    Summary theirs = status_of(*two.hand.node);
    EXPECT_EQ(text(theirs, "grip_state"), "safe");
    EXPECT_EQ(text(theirs, "session"), "none");
}

// Only the filter leaves afferents out, so that no other decoder has the number.
TEST(StatusOf, AHandTellsHowManyAfferentsItsFilterLeavesOut) {
    for (const bool filter : {true, false}) {
        TwoNodes two(press("", 20, filter ? "decoder { filter {} }" : "decoder { sliding_window {} }"));
        two.start();
        two.run_for(1s);
        Summary status = status_of(*two.hand.node);
        EXPECT_EQ(status.find("left_out_afferents") != nullptr, filter);
        if (filter) {
            EXPECT_EQ(status["left_out_afferents"].number(), 0);
        }
    }
}

TEST(SummaryOf, NodesOnALinkTellOfTheBusAndHowLateStepsRun) {
    TwoNodes two(press("bus {}", 20));
    two.start();
    two.run_for(1s);
    Summary ours = summary_of(*two.coprocessor.node);
    EXPECT_GT(ours["bus_events"].number(), 100);
    EXPECT_EQ(ours["bus_events"].number(), ours["events"].number());
    Summary theirs = summary_of(*two.hand.node);
    EXPECT_NE(theirs.find("step_lateness_p50_ms"), nullptr);
    EXPECT_NE(theirs.find("missed_deadlines"), nullptr);
}

TEST(SummaryOf, ACoprocessorTellsOfSamplesThatItHasClipped) {
    TwoNodes two(press(
        "", 20, "every_patch { sensor { full_scale_n: 0.1 } } gain { accept_unreachable_limit: true }"));
    two.start();
    two.run_for(1s);
    const Summary ours = summary_of(*two.coprocessor.node);
    ASSERT_NE(ours.find("notes"), nullptr);
    EXPECT_NE(ours.find("notes")->list().front().text()->find("beyond full scale"), std::string::npos)
        << *ours.find("notes")->list().front().text();
}

TEST(SummaryOf, ARunThatReachedItsEndWasNotInterrupted) {
    const Plan plan = make_plan(Scene::from_text("duration_s: 0.1 record { picture: false }"));
    const auto run = whole_run(plan);
    EXPECT_FALSE(interrupted(summary_of(*run, plan.end(), {}, std::nullopt)));
    EXPECT_TRUE(interrupted(summary_of(*run, plan.end() - 1ns, {}, std::nullopt)));
}

}  // namespace
}  // namespace afferent
