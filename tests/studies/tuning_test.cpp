#include "afferent/studies/tuning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
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

// Two afferents of a patch that is not the first, and differ.
Plan two() {
    return make_plan(
        Scene::from_text("patch { name: 'skin' kind: SA1 outline { rectangle { width_mm: 4 height_mm: 3 } } "
                         "afferents { place {} } } "
                         "patch { name: 'RA' kind: RA elements_of: 'skin' afferents { place { x_mm: -1 } "
                         "place { x_mm: 0.5 y_mm: 0.5 } } } "
                         "source { pushed {} } record { force: false picture: false }"));
}

TEST(Tuning, OfAPatchIsThatOfEachOfItsAfferents) {
    const Plan plan = two();
    double done = 0;
    const auto patch =
        value_or_throw(tuning_of_patch(plan, "RA", {.rate_hz = 500, .progress = [&](double part) {
                                                        EXPECT_GE(part, done);
                                                        done = part;
                                                    }}));
    EXPECT_EQ(done, 1);
    ASSERT_EQ(patch.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(patch[i].address, 1 + i);
        const AfferentTuning one =
            value_or_throw(tuning_of(plan, static_cast<Address>(1 + i), {.rate_hz = 500}));
        EXPECT_EQ(patch[i].place, one.place);
        EXPECT_EQ(patch[i].threshold_um, one.threshold_um);
        EXPECT_EQ(patch[i].field_mm2, one.field_mm2);
        EXPECT_EQ(patch[i].intervals_ms, one.intervals_ms);
        ASSERT_EQ(patch[i].frequencies.size(), one.frequencies.size());
        for (std::size_t k = 0; k < one.frequencies.size(); ++k)
            EXPECT_EQ(patch[i].frequencies[k].once_a_cycle_um, one.frequencies[k].once_a_cycle_um);
    }
    EXPECT_NE(patch[0].threshold_um, patch[1].threshold_um) << "their gains differ";
    const auto unknown = tuning_of_patch(plan, "PC");
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().text, "there is no patch \"PC\"");
}

TEST(Tuning, OfAPatchIsPrintedDrawnAndWritten) {
    AfferentTuning fires{.address = 7,
                         .patch = "tip",
                         .kind = "SA1",
                         .place = {1, 2},
                         .threshold_um = 20,
                         .field_mm2 = 3.5,
                         .frequencies = {{5, 40, 60}, {10, 30, std::nullopt}, {20, 35, std::nullopt}},
                         .hold_mm = 1,
                         .intervals_ms = {40, 60}};
    AfferentTuning silent{.address = 8, .patch = "tip", .kind = "SA1", .place = {-1.5, 0}, .hold_mm = 1};
    const std::vector<AfferentTuning> patch{fires, silent};
    std::ostringstream text;
    print(patch, text);
    EXPECT_NE(text.str().find("Patch tip, 2 afferents of kind SA1"), std::string::npos) << text.str();
    EXPECT_NE(text.str().find("best_hz                    1          10          10          10"),
              std::string::npos)
        << text.str();

    const SkinMaps maps = tuning_maps(patch);
    EXPECT_EQ(maps.places, (std::vector<Position>{{1, 2}, {-1.5, 0}}));
    ASSERT_EQ(maps.maps.size(), 6U);
    for (const SkinMaps::Map& map : maps.maps) ASSERT_EQ(map.values.size(), 2U) << map.title;
    EXPECT_EQ(maps.maps[0].values[0], 20);
    EXPECT_TRUE(std::isnan(maps.maps[0].values[1]));

    const auto file = std::filesystem::path(testing::TempDir()) / "afferent-tuning-map.csv";
    ASSERT_TRUE(write_map(patch, file));
    std::ifstream in(file);
    const std::string written{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(
        written,
        "address,x_mm,y_mm,threshold_um,field_mm2,held_hz,best_hz,best_threshold_um,interval_variation\n"
        "7,1,2,20,3.5,20,10,30,0.2\n"
        "8,-1.5,0,,,0,,,\n");
    std::filesystem::remove(file);
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
