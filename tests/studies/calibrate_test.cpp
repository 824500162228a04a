// A calibration finds the parameters of a simulated run.
#include "afferent/studies/calibrate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/nodes/run.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

constexpr Duration row_distance = 10ms;

double grip_n(double time_s) { return std::max(0.0, 7 * std::sin(time_s) + 1.5 * std::sin(5 * time_s)); }

// What is to be found: gains and biases that no tuning gives, and shares of different sizes. What is worn
// feels nothing any more.
Scene true_scene() {
    return Scene::from_text(R"(
        duration_s: 6 link { tcp {} } source { pushed {} } decoder { filter {} }
        patch { name: "thumb" elements: 3 share: [0.20, 0.18, 0.12] encoder { sustained { gain_mv_per_n: 30 bias_mv: 14.2 } } }
        patch { name: "index" elements: 2 share: [0.25, 0.15] encoder { sustained { gain_mv_per_n: 30 bias_mv: 13.5 } } }
        patch { name: "quick" elements_of: "thumb" encoder { transient { gain_mv_s_per_n: 1 } } }
        patch { name: "worn" elements: 1 share: 0.1 encoder { sustained { gain_mv_per_n: 30 bias_mv: 14 } } })");
}

// What the scene says before it is calibrated.
Scene wrong_scene() {
    return Scene::from_text(R"(
        duration_s: 6 link { tcp {} } source { pushed {} } decoder { filter {} }
        patch { name: "thumb" elements: 3 }
        patch { name: "index" elements: 2 }
        patch { name: "quick" elements_of: "thumb" encoder { transient { gain_mv_s_per_n: 1 } } }
        patch { name: "worn" elements: 1 share: 0.1 })");
}

std::vector<Event> spikes_of(const Scene& scene) {
    const Plan plan = make_plan(scene);
    Coprocessor coprocessor(plan);
    std::vector<Event> events;
    for (std::uint64_t k = 0; sample_time(k, 200) < plan.end(); ++k) {
        const TimePoint now = sample_time(k, 200);
        for (const PatchPlan& patch : plan.patches) {
            if (!patch.owns_elements) continue;
            std::vector<double> forces_n = patch.share;
            for (double& force_n : forces_n) force_n *= patch.name == "worn" ? 0 : grip_n(seconds(now));
            coprocessor.push({now, patch.first_element, forces_n});
        }
        const auto fired = coprocessor.advance(now + 5ms - 1ns);
        events.insert(events.end(), fired.begin(), fired.end());
    }
    return events;
}

// With a column for each element, or for the grip.
Table forces_of(const Scene& scene, bool by_grip) {
    Table table{.file = "forces.csv", .columns = {}, .times = {}, .values = {}};
    std::vector<double> shares;
    for (const scene::Patch& patch : scene.patches)
        shares.insert(shares.end(), patch.share.begin(), patch.share.end());
    if (by_grip) shares = {1};
    for (std::size_t i = 0; i < shares.size(); ++i) table.columns.push_back(std::to_string(i) + "_n");
    for (TimePoint time = scene_start; time < scene.end(); time += row_distance) {
        table.times.push_back(time);
        for (const double share : shares) table.values.push_back(share * grip_n(seconds(time)));
    }
    return table;
}

void expect_found(const SceneFit& fit) {
    const Scene truth = true_scene();
    ASSERT_EQ(fit.patches.size(), 3U) << "those with sustained encoders";
    ASSERT_EQ(fit.scene.patches.size(), 4U);
    for (const std::size_t i : {0U, 1U}) {
        const auto& found = std::get<scene::Sustained>(fit.scene.patches[i].encoder);
        const auto& made = std::get<scene::Sustained>(truth.patches[i].encoder);
        // Samples are held for 5 ms, and rows 10 ms apart: a percent of what moves.
        EXPECT_NEAR(found.gain_mv_per_n.value(), 30, 0.02 * 30);
        EXPECT_NEAR(found.bias_mv.value(), made.bias_mv.value(), 0.5);
        ASSERT_EQ(fit.scene.patches[i].share.size(), truth.patches[i].share.size());
        for (std::size_t e = 0; e < truth.patches[i].share.size(); ++e)
            EXPECT_NEAR(fit.scene.patches[i].share[e], truth.patches[i].share[e], 0.003);
        ASSERT_EQ(fit.patches[i].afferents.size(), truth.patches[i].share.size());
        for (const SceneFit::Afferent& afferent : fit.patches[i].afferents) {
            ASSERT_TRUE(afferent.fit) << afferent.address;
            EXPECT_LT(afferent.fit->residual_mv / afferent.fit->gain_mv_per_n, 0.05) << "in N";
        }
    }
    EXPECT_FALSE(fit.patches.at(2).fit) << "an afferent that never fires tells nothing";
    EXPECT_EQ(fit.scene.patches.at(3).encoder, wrong_scene().patches.at(3).encoder);
    EXPECT_EQ(fit.scene.patches.at(2).encoder, truth.patches.at(2).encoder)
        << "the transient ones are as they were";
}

TEST(Calibrate, FindsSharesGainsAndBiasesFromForcesOnEachElementAndSpikes) {
    const auto fit = calibrate(wrong_scene(), forces_of(true_scene(), false), spikes_of(true_scene()));
    ASSERT_TRUE(fit) << fit.error().text;
    expect_found(fit.value());
    ASSERT_EQ(fit.value().elements.size(), 6U);
    for (const SceneFit::Element& element : fit.value().elements)
        EXPECT_LT(element.share_residual_n.value(), 1e-12);
    EXPECT_NEAR(fit.value().scene.patches.at(3).share.at(0), 0.1, 1e-12);
}

TEST(Calibrate, FindsThemFromTheGripForceAndSpikesWhereGainsAreOne) {
    const auto fit = calibrate(wrong_scene(), forces_of(true_scene(), true), spikes_of(true_scene()));
    ASSERT_TRUE(fit) << fit.error().text;
    expect_found(fit.value());
    EXPECT_EQ(fit.value().elements.size(), 5U) << "the silent one keeps its share";
    EXPECT_EQ(fit.value().scene.patches.at(3).share.at(0), 0.1);
}

// Each of those patches is tuned by itself, and so has a gain of its own.
TEST(Calibrate, KeepsWhatThePatchesShareWhereTheSceneSaysIt) {
    const Scene truth = Scene::from_text(
        "duration_s: 5 source { pushed {} } patch { name: 'a' elements: 2 share: [0.5, 0.1] } patch { name: "
        "'b' elements: "
        "2 share: [0.3, 0.1] }");
    Scene scene = truth;
    scene.patches[0].share = {0.3, 0.3};
    scene.patches[1].share = {0.2, 0.2};
    const auto fit = calibrate(scene, forces_of(truth, true), spikes_of(truth));
    ASSERT_TRUE(fit) << fit.error().text;
    const Plan plan = make_plan(truth);
    ASSERT_EQ(fit.value().patches.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        ASSERT_TRUE(fit.value().patches[i].fit);
        EXPECT_NEAR(fit.value().patches[i].fit->gain_mv_per_n, plan.patches[i].gain(),
                    0.02 * plan.patches[i].gain());
        for (std::size_t e = 0; e < 2; ++e)
            EXPECT_NEAR(fit.value().scene.patches[i].share.at(e), truth.patches[i].share[e], 0.003);
    }
}

// Two elements that pass a tenth of their shares to each other and back: a square wave of 1 Hz, whose
// autocorrelation falls on a straight line from 1 to −1 in half a period.
TEST(Calibrate, WritesHowFarSharesWanderAndHowFast) {
    const Scene scene = Scene::from_text("patch { name: 'a' elements: 2 } source { pushed {} }");
    Table table{.file = "n.csv", .columns = {"a_n", "b_n"}, .times = {}, .values = {}};
    for (int k = 0; k < 2000; ++k) {
        table.times.push_back(scene_start + k * row_distance);
        const double part = k / 50 % 2 == 0 ? 0.1 : -0.1;
        for (const double sign : {1, -1}) table.values.push_back(3 * (1 + sign * part));
    }
    const auto fit = calibrate(scene, table, {});
    ASSERT_TRUE(fit) << fit.error().text;
    ASSERT_TRUE(fit.value().shares_wander);
    EXPECT_NEAR(fit.value().shares_wander->part, 0.1, 1e-3);
    EXPECT_NEAR(fit.value().shares_wander->time_s, 0.25 * (1 - std::exp(-1)), 0.01);
    EXPECT_EQ(fit.value().scene.uncertainty.share, fit.value().shares_wander->part);
    EXPECT_EQ(fit.value().scene.uncertainty.share_time_s, fit.value().shares_wander->time_s);
    EXPECT_FALSE(fit.value().gain_spread) << "there are no spikes";
    EXPECT_EQ(fit.value().scene.uncertainty.gain, Uncertainty().gain);
}

// One afferent's gain is a tenth above that of the other: a twentieth about their mean, nearly.
TEST(Calibrate, WritesHowMuchGainsOfAfferentsDiffer) {
    Scene truth = Scene::from_text(
        "duration_s: 6 source { pushed {} } patch { name: 'a' elements: 1 share: 0.5 encoder { sustained { "
        "gain_mv_per_n: 30 bias_mv: 14 } } } patch { name: 'b' elements: 1 share: 0.5 encoder { sustained { "
        "gain_mv_per_n: 33 bias_mv: 14 } } }");
    const Scene scene =
        Scene::from_text("duration_s: 6 source { pushed {} } patch { name: 'both' elements: 2 }");
    const auto fit = calibrate(scene, forces_of(truth, false), spikes_of(truth));
    ASSERT_TRUE(fit) << fit.error().text;
    ASSERT_TRUE(fit.value().gain_spread);
    EXPECT_NEAR(*fit.value().gain_spread, 0.05, 0.01);
    EXPECT_EQ(fit.value().scene.uncertainty.gain, *fit.value().gain_spread);
}

TEST(Calibrate, LeavesOutAColumnThatNeverChanges) {
    const Scene scene = Scene::from_text("patch { name: 'a' elements: 3 } source { pushed {} }");
    Table table{.file = "n.csv", .columns = {"a_n", "b_n", "c_n"}, .times = {}, .values = {}};
    for (int k = 0; k < 400; ++k) {
        table.times.push_back(scene_start + k * row_distance);
        for (const double share : {0.6, 0.4}) table.values.push_back(share * grip_n(0.01 * k));
        table.values.push_back(7);
    }
    const auto fit = calibrate(scene, table, {});
    ASSERT_TRUE(fit) << fit.error().text;
    ASSERT_EQ(fit.value().elements.size(), 3U);
    EXPECT_TRUE(fit.value().elements[2].dead);
    EXPECT_FALSE(fit.value().elements[0].dead);
    const scene::Patch& patch = fit.value().scene.patches[0];
    ASSERT_EQ(patch.share.size(), 3U);
    EXPECT_NEAR(patch.share[0], 0.6, 1e-9);
    EXPECT_NEAR(patch.share[1], 0.4, 1e-9);
    EXPECT_EQ(patch.share[2], 0);
    EXPECT_EQ(patch.sensor.dead_element, std::vector<std::uint32_t>{2});
}

// The curve of a sensor, in counts.
TEST(Calibrate, TakesCountsThroughTheCurveOfTheSensor) {
    Scene scene = Scene::from_text(
        "patch { name: 'a' elements: 2 sensor { adc_bits: 16 force_resistance {} } } source { pushed {} }");
    const Sensor sensor(scene.patches[0].sensor);
    Table table{.file = "counts.csv", .columns = {"a_counts", "b_counts"}, .times = {}, .values = {}};
    for (int k = 0; k < 400; ++k) {
        table.times.push_back(scene_start + k * row_distance);
        for (const double share : {0.7, 0.3}) {
            Sensor::State state;
            table.values.push_back(sensor.counts(state, share * grip_n(0.01 * k), 0));
        }
    }
    const auto fit = calibrate(scene, table, {});
    ASSERT_TRUE(fit) << fit.error().text;
    // A count at 6 N is 2 mN.
    EXPECT_NEAR(fit.value().scene.patches.at(0).share.at(0), 0.7, 1e-3);
    EXPECT_NEAR(fit.value().scene.patches.at(0).share.at(1), 0.3, 1e-3);
    EXPECT_TRUE(fit.value().patches.empty());
}

// From a force alone: how it moves, which the scene's filter is told, and another decoder is not.
TEST(Calibrate, FindsTheFiltersNoiseFromAForceAlone) {
    const Table table = forces_of(true_scene(), true);
    const auto fit = calibrate(wrong_scene(), table, {});
    ASSERT_TRUE(fit) << fit.error().text;
    ASSERT_TRUE(fit.value().motions);
    EXPECT_GT(fit.value().motions->score, fit.value().motions->score_before);
    const Plan plan = make_plan(fit.value().scene);
    const auto& planned = std::get<FilterParameters>(plan.controller.value().decoder).motion;
    const auto& found = fit.value().motions->force.motion;
    for (const auto motion : {ForceBelief::hold, ForceBelief::movement, ForceBelief::contact})
        EXPECT_EQ(planned[motion].speed_n_per_s, found[motion].speed_n_per_s) << motion;
    EXPECT_EQ(planned[ForceBelief::hold].drift_n2_per_s, found[ForceBelief::hold].drift_n2_per_s);
    Scene window = wrong_scene();
    window.decoder.kind = scene::SlidingWindow();
    EXPECT_EQ(value_or_throw(calibrate(window, table, {})).scene.decoder, window.decoder);
    EXPECT_EQ(fit.value().scene.patches, wrong_scene().patches);
}

TEST(Calibrate, RefusesWhatIsOfAnotherScene) {
    Table table = forces_of(true_scene(), false);
    table.columns[1] = "1_counts";
    const auto mixed = calibrate(wrong_scene(), table, {});
    ASSERT_FALSE(mixed);
    EXPECT_NE(mixed.error().text.find("forces.csv:1: must have one column of grip force"), std::string::npos);
    const auto stranger =
        calibrate(wrong_scene(), forces_of(true_scene(), true), std::vector<Event>{{scene_start, 77}});
    ASSERT_FALSE(stranger);
    EXPECT_NE(stranger.error().text.find("address 77"), std::string::npos);
}

}  // namespace
}  // namespace afferent
