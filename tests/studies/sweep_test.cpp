#include "afferent/studies/sweep.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/nodes/whole_run.hpp"

namespace afferent {
namespace {

Scene swept_grasp() { return Scene::from_text("duration_s: 4 link { udp {} }", "short"); }

TEST(Sweep, CountsThroughEveryCombination) {
    const SweepAxis axes[] = {SweepAxis::from("neuron.delta_g=0, 0.1"),
                              SweepAxis::from("link.packet_ms=1,20")};
    const auto points = sweep(swept_grasp(), axes);
    ASSERT_EQ(points.size(), 4u);
    const char* expected[][2] = {{"0", "1"}, {"0", "20"}, {"0.1", "1"}, {"0.1", "20"}};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(points[i].settings, (std::vector<Setting>{{"neuron.delta_g", expected[i][0]},
                                                            {"link.packet_ms", expected[i][1]}}));
        ASSERT_TRUE(points[i].figures) << points[i].refusal;
    }
    // Adaptation saves events, and shorter packets cost bytes.
    EXPECT_GT(points[0].figures->events, points[2].figures->events);
    EXPECT_GT(points[2].figures->link_bytes, points[3].figures->link_bytes);
}

TEST(Sweep, GivesTheFiguresOfTheRunItself) {
    const SweepAxis axes[] = {SweepAxis::from("decoder=inversion")};
    const auto points = sweep(swept_grasp(), axes);
    ASSERT_EQ(points.size(), 1U);
    ASSERT_TRUE(points[0].figures) << points[0].refusal;
    const Plan plan = make_plan(swept_grasp().with(points[0].settings));
    double squares = 0;
    double steps = 0;
    const auto run = whole_run(plan, {.step = [&](const ControllerStep& step) {
                                   const double error = step.estimate.force_n - step.true_force_n.value();
                                   squares += error * error;
                                   ++steps;
                               }});
    EXPECT_EQ(points[0].figures->events, run->coprocessor().events());
    EXPECT_EQ(points[0].figures->link_bytes, run->link_bytes());
    EXPECT_EQ(points[0].figures->force_error_rms_n, std::sqrt(squares / steps));
}

TEST(Sweep, IsTheSameForAnyNumberOfThreads) {
    const SweepAxis axes[] = {SweepAxis::from("seed=1,2,3,4,5")};
    const auto one = sweep(swept_grasp(), axes, {.threads = 1});
    const auto four = sweep(swept_grasp(), axes, {.threads = 4});
    ASSERT_EQ(one.size(), 5U);
    ASSERT_EQ(four.size(), 5U);
    for (std::size_t i = 0; i < one.size(); ++i) {
        ASSERT_TRUE(one[i].figures && four[i].figures) << one[i].refusal << four[i].refusal;
        EXPECT_EQ(one[i].figures->events, four[i].figures->events);
        EXPECT_EQ(one[i].figures->force_error_rms_n, four[i].figures->force_error_rms_n);
    }
}

TEST(Sweep, TellsWhichCombinationsAreNoScene) {
    const SweepAxis axes[] = {SweepAxis::from("neuron.tau_m_ms=-1,10")};
    const auto points = sweep(swept_grasp(), axes);
    ASSERT_EQ(points.size(), 2U);
    EXPECT_FALSE(points[0].figures);
    EXPECT_NE(points[0].refusal.find("neuron.tau_m_ms=-1: "), std::string::npos) << points[0].refusal;
    EXPECT_TRUE(points[1].figures);
}

TEST(Sweep, RefusesWhatNoCombinationCanMend) {
    const auto with = [](const char* axis) {
        const SweepAxis axes[] = {SweepAxis::from(axis)};
        return sweep(swept_grasp(), axes);
    };
    EXPECT_THROW(with("neuron.delta_gg=1,2"), SceneError);
    EXPECT_THROW(sweep(swept_grasp(), {}), SceneError);
    Scene pushed = swept_grasp();
    pushed.source = scene::Pushed();
    const SweepAxis over_seeds[] = {SweepAxis::from("seed=1,2")};
    EXPECT_THROW(sweep(pushed, over_seeds), SceneError);
    std::vector<SweepAxis> many(3, SweepAxis{"seed", std::vector<std::string>(100, "1")});
    EXPECT_THROW(sweep(swept_grasp(), many), SceneError);
}

TEST(Sweep, SplitsValuesAtOuterCommasOnly) {
    EXPECT_EQ(SweepAxis::from("patch.share=[0.5, 0.5, 0],[1,0,0]").values,
              (std::vector<std::string>{"[0.5, 0.5, 0]", "[1,0,0]"}));
    EXPECT_EQ(SweepAxis::from("link.channel=,{loss: 0.1, latency_ms: 2}").values,
              (std::vector<std::string>{"", "{loss: 0.1, latency_ms: 2}"}));
}

TEST(Sweep, StopsWhereItIsToldTo) {
    Scene endless = swept_grasp();
    endless.duration_s = 1e6;  // would take hours
    const SweepAxis axes[] = {SweepAxis::from("seed=1,2,3,4")};
    const auto caller = std::this_thread::get_id();
    int asked = 0;
    const auto points = sweep(endless, axes, {.progress = [&](double fraction) {
                                  EXPECT_EQ(std::this_thread::get_id(), caller);
                                  EXPECT_LT(fraction, 1);
                                  ++asked;
                                  return false;
                              }});
    EXPECT_EQ(asked, 1);
    EXPECT_EQ(points.size(), 4U);
    for (const SweepPoint& point : points) {
        EXPECT_FALSE(point.figures);
        EXPECT_EQ(point.refusal, "");
    }
}

}  // namespace
}  // namespace afferent
