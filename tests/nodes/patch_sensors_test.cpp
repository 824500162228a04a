#include "afferent/nodes/patch_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

TEST(PatchSensors, GiveEachElementItsShare) {
    const Plan plan = make_plan(
        Scene::from_text("patch { name: 'a' elements: 2 share: [0.75, 0.25] sensor { adc_bits: 16 } }"));
    PatchSensors sensors(plan.patches[0], 1);
    const auto forces_n = sensors.feel(8);
    ASSERT_EQ(forces_n.size(), 2U);
    // Half a count of 16 bits over 10 N.
    EXPECT_NEAR(forces_n[0], 6, 10.0 / 65535 / 2);
    EXPECT_NEAR(forces_n[1], 2, 10.0 / 65535 / 2);
}

TEST(PatchSensors, TellOfTheForceOfADelayAgo) {
    const auto told = [](const char* delay_ms) {
        const Plan plan =
            make_plan(Scene::from_text("patch { name: 'a' elements: 1 share: 1 sensor { full_scale_n: 20 "
                                       "adc_bits: 24 rate_hz: 200 delay_ms: " +
                                       std::string(delay_ms) + " } }"));
        PatchSensors sensors(plan.patches[0], 1);
        std::vector<double> all;
        for (const double force_n : {1, 2, 3, 4, 5})
            all.push_back(std::round(sensors.feel(sensors.arriving_n(force_n))[0]));
        return all;
    };
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'a' elements: 1 share: 1 sensor { full_scale_n: 20 adc_bits: 24 delay_ms: 10 } }"));
    EXPECT_NEAR(PatchSensors(plan.patches[0], 1).feel(3)[0], 3, 1e-5) << "samples of others are as they come";
    EXPECT_EQ(told("0"), (std::vector<double>{1, 2, 3, 4, 5}));
    EXPECT_EQ(told("10"), (std::vector<double>{0, 0, 1, 2, 3})) << "two scans of 5 ms";
    EXPECT_EQ(told("10.1"), (std::vector<double>{0, 0, 0, 1, 2})) << "whole scans";
}

TEST(PatchSensors, CountWhatIsBeyondTheirRangeAndNotWhatIsAtItsEnds) {
    const Plan plan = make_plan(
        Scene::from_text("patch { name: 'a' elements: 4 sensor { adc_bits: 12 full_scale_n: 10 } }"));
    PatchSensors sensors(plan.patches[0], 1);
    sensors.take_counts(std::vector<double>{0, 4095, -1, 4096});
    EXPECT_EQ(sensors.clipped(), 2U);
    const auto forces_n = sensors.take_newtons(std::vector<double>{0, 10, -0.1, 10.1});
    EXPECT_EQ(sensors.clipped(), 4U);
    EXPECT_EQ(std::vector<double>(forces_n.begin(), forces_n.end()), (std::vector<double>{0, 10, 0, 10}));
}

TEST(PatchSensors, ReadDeadAndStuckElementsAsSuch) {
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'a' sensor { dead_element: 0 stuck_element { element: 2 force_n: 1.5 } } }"));
    PatchSensors sensors(plan.patches[0], 1);
    for (const double grip_n : {0.0, 9.0}) {
        EXPECT_EQ(sensors.feel(grip_n)[0], 0);
        EXPECT_EQ(sensors.feel(grip_n)[2], 1.5);
    }
    EXPECT_GT(sensors.feel(9)[1], 2.9);
}

TEST(PatchSensors, CalibrateCountsByTheScenesTable) {
    const Plan plan =
        make_plan(Scene::from_text(R"(source { pushed {} } patch { name: "a" elements: 1 sensor {
        calibration { counts: 1000 force_n: 0 } calibration { counts: 2000 force_n: 4 } } })"));
    PatchSensors sensors(plan.patches[0], 1);
    EXPECT_EQ(sensors.take_counts(std::vector{1500.0})[0], 2);
    EXPECT_EQ(sensors.take_counts(std::vector{9000.0})[0], 4);
    EXPECT_EQ(sensors.clipped(), 1U) << "the converter has 12 bits";
}

TEST(PatchSensors, ClipAndCountWhatIsOutOfRange) {
    const Plan plan = make_plan(
        Scene::from_text("source { pushed {} } patch { name: 'a' elements: 2 sensor { full_scale_n: 5 } }"));
    PatchSensors sensors(plan.patches[0], 1);
    EXPECT_EQ(sensors.take_newtons(std::vector{-1.0, 7.0})[0], 0);
    EXPECT_EQ(sensors.take_newtons(std::vector{-1.0, 7.0})[1], 5);
    EXPECT_EQ(sensors.clipped(), 4U);
    EXPECT_EQ(sensors.samples(), 4U);
}

TEST(PatchSensors, AddNoiseThatDependsOnTheSeedAlone) {
    const Plan plan = make_plan(
        Scene::from_text("source { pushed {} } patch { name: 'a' elements: 1 sensor { noise_counts: 20 } }"));
    const auto felt = [&](std::uint64_t seed) {
        PatchSensors sensors(plan.patches[0], seed);
        std::vector<double> forces_n;
        for (int i = 0; i < 20; ++i) forces_n.push_back(sensors.feel(5)[0]);
        return forces_n;
    };
    EXPECT_EQ(felt(1), felt(1));
    EXPECT_NE(felt(1), felt(2));
}

}  // namespace
}  // namespace afferent
