#include "afferent/studies/tuning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "afferent/neurons/rate.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/studies/tuning_report.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent {
namespace {

constexpr double radius_mm = 0.5;

// One afferent of a kind, in the middle of its skin.
Plan one(scene::Kind kind, double noise_mv = 0) {
    Scene scene;
    scene.patches = {scene::preset(kind)};
    scene::Patch& patch = scene.patches[0];
    patch.name = "skin";
    patch.spread = {};
    patch.neuron.noise_mv = noise_mv;
    patch.nerve.emplace();
    patch.outline = scene::Outline{.shape = scene::Rectangle{3, 3}, .pitch_mm = 0.25, .centre = {100, 20}};
    patch.sensor.rate_hz = 5000;
    patch.afferents->place = {{0.25, -0.5}};
    scene.source = scene::Pushed();
    scene.record = {.events = true, .force = false, .picture = false};
    return make_plan(scene);
}

// What it reads for an indentation of 1 mm: E* √2 / (π σ) · D(a / (√2 σ)), with Dawson's integral D.
double felt_n(const scene::Patch& patch) {
    const double sd_mm = patch.afferents->field_sd_mm;
    const double x = radius_mm / (std::numbers::sqrt2 * sd_mm);
    constexpr int steps = 10'000;
    double dawson = 0;
    for (int i = 0; i < steps; ++i)
        dawson += x / steps * std::exp(std::pow((i + 0.5) / steps * x, 2) - x * x);
    return 0.05 / (1 - 0.16) * std::numbers::sqrt2 / (std::numbers::pi * sd_mm) * dawson;
}

double best_hz(const AfferentTuning& tuning) {
    return std::ranges::min_element(tuning.frequencies, {},
                                    [](const auto& each) { return each.threshold_um.value_or(HUGE_VAL); })
        ->hz;
}

TEST(Tuning, OfSa1IsThatOfItsNeuronAndItsField) {
    const Plan plan = one(scene::Kind::sa1);
    const AfferentTuning tuning = value_or_throw(tuning_of(plan, 0));
    EXPECT_EQ(tuning.kind, "SA1");
    EXPECT_EQ(tuning.place, (Position{100.25, 19.5}));
    EXPECT_EQ(tuning.rate_hz, 5000);
    const LifParameters& neuron = std::get<LifParameters>(plan.patches[0].neuron);
    const double drive_mv = plan.patches[0].gain() * felt_n(plan.scene.patches[0]);  // at 1 mm
    const double threshold_um = 1000 * (neuron.v_th_mv - neuron.v_r_mv) / drive_mv;
    EXPECT_NEAR(tuning.threshold_um.value() / threshold_um, 1, 0.05);
    EXPECT_NEAR(tuning.field_depth_um, 4.5 * *tuning.threshold_um, 1e-9);
    // The steady rate, and nothing else than that in the hold.
    const double rate_hz = afferent::rate_hz(RateKind::steady, neuron, drive_mv);
    ASSERT_GT(tuning.intervals_ms.size(), 10U);
    for (const double each : tuning.intervals_ms) EXPECT_NEAR(each * rate_hz / 1000, 1, 0.04);
    for (const auto& each : tuning.depths) {
        const double held_hz = afferent::rate_hz(RateKind::steady, neuron, each.depth_mm * drive_mv);
        EXPECT_NEAR(each.held_hz, held_hz, 2.5 + 0.05 * held_hz) << each.depth_mm;
        EXPECT_GE(each.onset_hz, each.held_hz) << each.depth_mm;
    }
    // The same on both sides, and in both directions, but for the elements' steps.
    ASSERT_EQ(tuning.field.size(), 41U);
    EXPECT_EQ(tuning.field[20].offset_mm, 0);
    EXPECT_GT(tuning.field[20].along_x, 0);
    EXPECT_EQ(tuning.field.front().along_x + tuning.field.back().along_y, 0) << "it ends";
    double across_mm = 0;
    for (const auto& each : tuning.field)
        if (each.along_x > 0) across_mm += tuning.field[1].offset_mm - tuning.field[0].offset_mm;
    EXPECT_NEAR(tuning.field_mm2, std::numbers::pi / 4 * across_mm * across_mm, 0.2 * tuning.field_mm2);
}

TEST(Tuning, HasTheBestFrequencyOfTheKind) {
    const AfferentTuning ra = value_or_throw(tuning_of(one(scene::Kind::ra), 0));
    EXPECT_EQ(best_hz(ra), 45);
    EXPECT_TRUE(ra.intervals_ms.empty()) << "it does not fire in a hold";
    const AfferentTuning pc = value_or_throw(tuning_of(one(scene::Kind::pc), 0));
    EXPECT_EQ(best_hz(pc), 250);
    EXPECT_GT(pc.field_mm2, 3 * ra.field_mm2) << "all of the skin that there is";
    for (const auto& each : pc.frequencies)
        if (each.once_a_cycle_um) {
            EXPECT_GE(*each.once_a_cycle_um, each.threshold_um.value()) << each.hz;
        }
}

TEST(Tuning, TellsNoFrequencyThatItsSamplesDoNotShow) {
    double done = 0;
    const AfferentTuning tuning =
        value_or_throw(tuning_of(one(scene::Kind::sa1), 0, {.rate_hz = 200, .progress = [&](double part) {
                                                                EXPECT_GE(part, done);
                                                                done = part;
                                                            }}));
    EXPECT_EQ(tuning.frequencies.back().hz, 45);
    EXPECT_EQ(done, 1);
}

TEST(Tuning, ShowsHowIrregularNoiseMakesAHold) {
    const auto variation = [](double noise_mv) {
        const Summary summary = summary_of(value_or_throw(tuning_of(one(scene::Kind::sa1, noise_mv), 0)));
        return summary.find("interval_variation")->number().value();
    };
    EXPECT_LT(variation(0), 1e-6);
    EXPECT_GT(variation(4), 0.1);
}

TEST(Tuning, IsRefusedWhereThereIsNothingToTouch) {
    const Plan plan = one(scene::Kind::sa1);
    const auto refusal = [](const Plan& of, Address address, const TuningOptions& options = {}) {
        const auto tuning = tuning_of(of, address, options);
        return tuning ? "accepted" : tuning.error().text;
    };
    EXPECT_EQ(refusal(plan, 1), "there is no address 1: the scene has 1");
    EXPECT_EQ(refusal(plan, 0, {.radius_mm = 0}), "radius, depth and rate must be above 0");
    const Plan flat = make_plan(Scene::from_text("patch { name: 'a' } source { pushed {} }"));
    EXPECT_NE(refusal(flat, 0).find("patch \"a\" has no places that a probe could touch"), std::string::npos);
}

TEST(Tuning, IsPrintedAndDrawn) {
    const AfferentTuning tuning = value_or_throw(tuning_of(one(scene::Kind::pc), 0));
    std::ostringstream text;
    print(tuning, text);
    for (const char* part : {"PC, address 0 of patch skin at 100.2, 19.5 mm", "frequency_hz", "held_hz",
                             "from half a second on, it fires no longer."})
        EXPECT_NE(text.str().find(part), std::string::npos) << text.str();
    const PanelGrid picture = tuning_picture(tuning);
    ASSERT_EQ(picture.panels.size(), 3U) << "no intervals";
    EXPECT_EQ(picture.panels[1].curves[0].x.size(), tuning.frequencies.size());
}

}  // namespace
}  // namespace afferent
