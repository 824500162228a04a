// Scans that a program pushes.
#include "afferent/nodes/pushed_source.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/run.hpp"
#include "tests/since_start.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

constexpr const char* two_patches = R"(
    duration_s: 1 source { pushed {} } link { in_process {} }
    patch { name: "thumb" elements: 3 sensor { full_scale_n: 20 } }
    patch { name: "finger" elements: 2 sensor { dead_element: 1 } } )";

std::vector<double> taken(PushedSource& source) {
    const auto scan = source.take(0);
    return {scan.value().forces_n.begin(), scan.value().forces_n.end()};
}

TEST(PushedSource, GivesScansInTheOrderInWhichTheyCame) {
    const Plan plan = make_plan(Scene::from_text(two_patches));
    PushedSource source(plan);
    EXPECT_EQ(source.next(), std::nullopt);
    ASSERT_TRUE(source.push({at(1ms), 3, std::vector{4.0, 5.0}}));
    ASSERT_TRUE(source.push({at(1ms), 0, std::vector{1.0, 2.0, 3.0}}));
    EXPECT_EQ(source.next(), (Due{at(1ms), Kind::scan, 1}));
    EXPECT_EQ(taken(source), (std::vector{4.0, 0.0})) << "the finger's second element is dead";
    EXPECT_EQ(source.next(), (Due{at(1ms), Kind::scan, 0}));
    EXPECT_EQ(taken(source), (std::vector{1.0, 2.0, 3.0}));
    EXPECT_EQ(source.next(), std::nullopt);
    EXPECT_EQ(source.samples(), 5U);
}

TEST(PushedSource, RefusesWhatIsNoScanOfAPatch) {
    const Plan plan = make_plan(Scene::from_text(two_patches));
    PushedSource source(plan);
    ASSERT_TRUE(source.push({at(5ms), 0, std::vector{1.0, 2.0, 3.0}}));
    const auto refusal = [&](TimePoint time, Address first, const std::vector<double>& forces_n) {
        const auto pushed = source.push({time, first, forces_n});
        return pushed ? "accepted" : pushed.error().text;
    };
    EXPECT_EQ(refusal(at(5ms), 1, {1.0, 2.0}), "a pushed scan begins at element 1, where no patch begins");
    EXPECT_EQ(refusal(at(5ms), 3, {1.0}), "a pushed scan has 1 forces; patch \"finger\" has 2 elements");
    EXPECT_EQ(refusal(at(4ms), 3, {1.0, 2.0}),
              "a pushed scan is of 0.004000 s, and one of 0.005000 s has come before it");
    EXPECT_EQ(refusal(at(5ms), 3, {1.0, 2.0}), "accepted");
    EXPECT_EQ(taken(source).size(), 3U);
    EXPECT_EQ(taken(source).size(), 2U);
    EXPECT_EQ(source.next(), std::nullopt) << "what was refused has left nothing";
}

TEST(PushedSource, HoldsTheLastForceOfWhatIsNotFinite) {
    const Plan plan = make_plan(Scene::from_text(two_patches));
    PushedSource source(plan);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    ASSERT_TRUE(source.push({at(0ms), 0, std::vector{nan, 2.0, 3.0}}));
    ASSERT_TRUE(source.push({at(1ms), 0, std::vector{1.0, nan, std::numeric_limits<double>::infinity()}}));
    EXPECT_EQ(taken(source), (std::vector{0.0, 2.0, 3.0}));
    EXPECT_EQ(taken(source), (std::vector{1.0, 2.0, 3.0}));
}

TEST(PushedSource, ClipsAndCountsWhatTheSensorCannotRead) {
    const Plan plan = make_plan(Scene::from_text(two_patches));
    PushedSource source(plan);
    ASSERT_TRUE(source.push({at(0ms), 0, std::vector{-1.0, 20.0, 21.0}}));
    EXPECT_EQ(taken(source), (std::vector{0.0, 20.0, 20.0}));
    EXPECT_EQ(source.clipped(), 2U);
}

TEST(PushedSource, DropsTheOldestWhereNobodyTakesThem) {
    const Plan plan = make_plan(Scene::from_text(two_patches));
    PushedSource source(plan, 3);
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(source.push({at(k * 1ms), 3, std::vector{1.0 + k, 0.0}}));
    EXPECT_EQ(source.dropped(), 2U);
    for (const double first_n : {3.0, 4.0, 5.0}) EXPECT_EQ(taken(source).at(0), first_n);
    EXPECT_EQ(source.next(), std::nullopt);
}

// The same samples, pushed a packet ahead: the same events as from the scene's own profile.
TEST(PushedSource, GivesTheEventsThatTheSamplesWouldHaveGiven) {
    const Plan plan = make_plan(Scene::from_text(R"(duration_s: 1 link { in_process {} } source { profile {
        point { time_s: 0.1 force_n: 0 } point { time_s: 0.3 force_n: 6 } } })"));
    std::vector<Event> expected;
    Scene pushed_scene = plan.scene;
    pushed_scene.source = scene::Pushed();
    const Plan pushed_plan = make_plan(pushed_scene);
    const auto link_end = value_or_throw(CoprocessorEnd::open(pushed_plan));
    ASSERT_NE(link_end->pushed(), nullptr);
    Observer output;
    output.events = [&](std::span<const Event> events) {
        expected.insert(expected.end(), events.begin(), events.end());
    };
    output.scan = [&](const Scan& scan) { ASSERT_TRUE(link_end->pushed()->push(scan)); };
    std::vector<Event> events;
    Observer pushed;
    pushed.events = [&](std::span<const Event> more) {
        events.insert(events.end(), more.begin(), more.end());
    };
    const auto run = value_or_throw(Run::open(plan, std::move(output)));
    while (!run->done()) {
        ASSERT_TRUE(run->do_next());
        while (link_end->next().time < run->next()) ASSERT_TRUE(link_end->do_next(pushed));
    }
    run->finish(plan.end());
    while (link_end->next().time <= plan.end()) ASSERT_TRUE(link_end->do_next(pushed));
    link_end->finish(plan.end(), pushed);
    EXPECT_GT(expected.size(), 50U);
    EXPECT_EQ(events, expected);
}

}  // namespace
}  // namespace afferent
