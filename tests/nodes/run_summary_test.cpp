// What a node says of itself while it runs, and a run once it is over.
#include "afferent/nodes/run_summary.hpp"

#include <gtest/gtest.h>

#include "tests/nodes/two_nodes.hpp"

namespace afferent {
namespace {

std::string text(Summary summary, const char* key) {
    const std::string* const found = summary[key].text();
    return found ? *found : "";
}

bool interrupted(Summary summary) { return std::get<bool>(summary["interrupted"].value()); }

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
