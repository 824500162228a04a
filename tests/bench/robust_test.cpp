// The worlds that are not as told are what they are said to be, and the scores what they are called.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <stdexcept>
#include <vector>

#include "bench/robust_bench.hpp"
#include "bench/robust_tables.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

// A rise within 1 s to 10 N, held for 4 s.
double grip_n(TimePoint time) { return 10 * std::min(1.0, seconds(time)); }

const RobustInput& input() {
    static const RobustInput made{Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb"),
                                  Scene::from_file(AFFERENT_SOURCE_DIR "/examples/paper.txtpb"),
                                  grip_n,
                                  {}};
    return made;
}

const RobustCase& case_named(const std::string& name) {
    return found_or_throw(robust_cases(), name, &RobustCase::name);
}

// The linear sensors of three fingers, under that grip, as the case has them.
World changed(const std::string& name, unsigned draw = 0) {
    const RobustCase& what = case_named(name);
    const std::vector<World> worlds = what.worlds(input());
    World world = found_or_throw(worlds, "held 35 N", &World::name);
    world.force_n = grip_n;
    world.duration = 5s;
    what.change(world, draw);
    return world;
}

double sensed_at(const World& world, Duration time) {
    return touched_force(world).sensed_n.at(static_cast<std::size_t>(time / Touch::step));
}

// To within the steps of nine converters of 12 bits for 10 N.
constexpr double resolution_n = 9 * 10.0 / 4095;

TEST(RobustWorld, AsToldHasTheEventsOfItsScene) {
    const World world("grasp", input().grasp, grip_n, 2s);
    const TouchedForce touched = touched_force(world);
    EXPECT_GT(touched.activity.events.size(), 100U);
    EXPECT_EQ(touched.activity.events, touched_force(input().grasp, 2s, grip_n).activity.events);
    EXPECT_EQ(touched.afferents, world.told.controller.value().afferents);
}

TEST(RobustWorld, ElementsTellTheirPartOfTheForce) {
    EXPECT_NEAR(sensed_at(changed("as_told"), 3s), 10, resolution_n);
    EXPECT_NEAR(sensed_at(changed("all_gains_low"), 3s), 9, resolution_n);
    EXPECT_NEAR(sensed_at(changed("all_gains_high"), 3s), 11, resolution_n);
    // The thumb has half of the force; where it does not touch, the others take it over.
    EXPECT_NEAR(sensed_at(changed("unloaded_thumb"), 3s), 10, resolution_n);
    EXPECT_NEAR(sensed_at(changed("dead_thumb"), 3s), 5, resolution_n);
    // 0.20 + 0.18 + 0.12 + 0.11, and 0.05 + 0.06 + 0.08 and one of 0.10.
    EXPECT_NEAR(sensed_at(changed("dead_largest"), 3s), 10 * (1 - 0.61), resolution_n);
    EXPECT_NEAR(sensed_at(changed("dead_smallest"), 3s), 10 * (1 - 0.29), resolution_n);
}

TEST(RobustWorld, ElementsDieInTheGripAndAreJudgedHalfASecondLater) {
    const World world = changed("dying_largest");
    ASSERT_FALSE(world.dies.empty());
    const TimePoint death = *std::ranges::min_element(world.dies);
    // The force is above 3 N from 0.3 to 5 s; the middle of it.
    EXPECT_NEAR(seconds(death), 2.65, 0.01);
    EXPECT_NEAR(sensed_at(world, death - scene_start - 10ms), 10, resolution_n);
    EXPECT_NEAR(sensed_at(world, death - scene_start + 10ms), 3.9, resolution_n);
    const TouchedForce force = touched_force(world);
    const std::vector<bool> counts = judged(world, force.true_n);
    const auto first = std::ranges::find(counts, true) - counts.begin();
    EXPECT_EQ(scene_start + first * Touch::step, death + 500ms);
}

TEST(RobustWorld, OnlyAFastReleaseIsJudged) {
    World world = changed("release");
    // At 20 N/s from 2 to 2.5 s, and at 5 N/s before.
    world.force_n = [](TimePoint time) {
        const double t = seconds(time);
        return t < 2 ? 20 - 5 * t : std::max(0.0, 10 - 20 * (t - 2));
    };
    const std::vector<bool> counts = judged(world, touched_force(world).true_n);
    // 10 ms in, by the slope over 10 ms, to 50 ms after.
    EXPECT_NEAR(static_cast<double>(std::ranges::count(counts, true)), 550, 10);
    EXPECT_FALSE(counts.at(1990));
    EXPECT_TRUE(counts.at(2300));
}

TEST(RobustWorld, DrawsOfGainsDifferAndRepeat) {
    EXPECT_EQ(changed("gains_10", 1).gain, changed("gains_10", 1).gain);
    EXPECT_NE(changed("gains_10", 1).gain, changed("gains_10", 2).gain);
    const auto gains = changed("gains_10", 1).gain;
    EXPECT_EQ(gains.size(), 9U);
    for (const double gain : gains) EXPECT_NEAR(gain, 1, 0.4);
}

// What is scaled is the unit of force, and nothing that a neuron feels.
TEST(RobustWorld, ScaledForcesGiveTheSameEvents) {
    const auto events = touched_force(changed("as_told")).activity.events;
    ASSERT_GT(events.size(), 500U);
    for (const char* name : {"tenth", "hundredth", "ten_times"}) {
        const World world = changed(name);
        const auto scaled = touched_force(world).activity.events;
        ASSERT_EQ(scaled.size(), events.size()) << name;
        // Forces are scaled to within the rounding of a product.
        for (std::size_t i = 0; i < events.size(); ++i)
            ASSERT_LE(std::abs((scaled[i].time - events[i].time).count()), 1000) << name << ", " << i;
        EXPECT_NEAR(world.force_n(scene_start + 3s) / world.unit_n, 10, 1e-12);
    }
}

TEST(RobustScore, CountsWhatItsColumnsSay) {
    RobustScore score;
    score.add(10, {.force_n = 10, .sigma_n = 1});
    score.add(10, {.force_n = 7, .sigma_n = 1, .left_out = 2});
    score.add(10, {.force_n = 13, .sigma_n = 1, .doubt = Doubt::slow});
    score.add(10, {.force_n = 8.01, .sigma_n = 1, .doubt = Doubt::saturated});
    score.finish();
    EXPECT_NEAR(score.rms_n, std::sqrt((9 + 9 + 1.99 * 1.99) / 4), 1e-12);
    EXPECT_NEAR(score.bias_n, -1.99 / 4, 1e-12);
    EXPECT_EQ(score.coverage_95, 0.25);
    EXPECT_EQ(score.above_2_sigma, 0.25);
    EXPECT_EQ(score.left_out, 0.5);
    EXPECT_EQ(score.saturated, 0.25);
    EXPECT_EQ(score.doubtful, 0.5);
}

TEST(RobustBench, MeasuresTheCasesAndDecodersThatAreNamed) {
    const RobustOptions options{.cases = {"sine", "gains_10"}, .decoders = {"inversion", "filter"}};
    const auto rows = measure_robustness(input(), options, [](double) {});
    // Two scenes of gains_10 with a decoder each, and the filter told of it; and the sine.
    ASSERT_EQ(rows.size(), 2U * 3 + 2);
    EXPECT_EQ(std::ranges::count(rows, true, &RobustRow::stated), 2);
    for (const RobustRow& row : rows) {
        EXPECT_GT(row.score.rms_n, 0) << row.what->name;
        EXPECT_LT(row.score.rms_n, 10) << row.what->name;
    }
    EXPECT_THROW(measure_robustness(input(), {.cases = {"nonsense"}}, [](double) {}), std::runtime_error);
    EXPECT_THROW(measure_robustness(input(), {.decoders = {"nonsense"}}, [](double) {}), std::runtime_error);
}

TEST(RobustBench, HasAnExplanationForEveryCase) {
    std::set<std::string> names;
    for (const RobustCase& each : robust_cases()) {
        EXPECT_TRUE(names.insert(each.name).second) << each.name;
        EXPECT_FALSE(each.wrong.empty()) << each.name;
        EXPECT_GE(each.draws, 1U) << each.name;
    }
    EXPECT_GT(names.size(), 10U);
}

TEST(RobustBench, WritesItsColumns) {
    const std::filesystem::path folder = testing::TempDir() + "robust";
    const RobustScore score{0.5, -0.25, 0.9, 0.05, 1, 0.125, 0.5, 100};
    write_robustness({{&case_named("lost"), "grasp", "filter", false, score},
                      {&case_named("lost"), "grasp", read_by_sensors, false, score}},
                     folder);
    std::ifstream file(folder / "robust.csv");
    std::string line;
    std::getline(file, line);
    EXPECT_EQ(line,
              "case,scene,decoder,wrong,stated,rms_n,bias_n,coverage_95,above_2_sigma,left_out,saturated,"
              "doubtful");
    std::getline(file, line);
    EXPECT_EQ(line, "lost,grasp,filter,10 % of packets lost,0,0.5,-0.25,0.9,0.05,1,0.125,0.5");
    std::getline(file, line);
    EXPECT_EQ(line, "lost,grasp,sensors,10 % of packets lost,0,0.5,-0.25,,,,,");
}

}  // namespace
}  // namespace afferent
