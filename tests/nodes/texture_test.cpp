// The texture read-out of a fingertip under gratings and textures that slide.
// `build/release/tests/nodes_tests
// --gtest_filter='Textures*'` prints the figures of docs/readouts.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "afferent/decoders/texture.hpp"
#include "tests/long_runs.hpp"
#include "tests/nodes/whole_run.hpp"

namespace afferent {
namespace {

constexpr const char* kinds_of_tip[]{"SA1", "RA"};

// The first window holds the press, which is not read here: three of 500 ms are told.
Scene fingertip_on(scene::Touch touch, std::uint64_t seed) {
    Scene scene = Scene::from_file(AFFERENT_SOURCE_DIR "/examples/fingertip.txtpb");
    std::erase_if(scene.patches, [](const auto& patch) { return patch.name == "PC"; });
    scene.source = std::move(touch);
    scene.duration_s = 1.6;
    scene.seed = seed;
    scene.record = {.events = true, .force = false, .picture = false};
    scene.decoder.kind = scene::Filter();  // which is planned faster than curves of rates
    scene.decoder.texture.emplace();
    return scene;
}

struct Grated {
    double period_mm = 2, speed_mm_per_s = 40, direction_deg = 0;
    std::uint64_t seed = 1;
    double depth_mm = 0.5;
};

// All of the tip rests on the surface, with a newton.
const Pad pad_of_tip{.width_mm = 15, .height_mm = 9, .peak_kpa = 20};

// On ridges half as wide as the period.
Scene fingertip_on(const Grated& slide) {
    scene::Touch touch;
    touch.grating = {{.period_mm = slide.period_mm,
                      .ridge_mm = slide.period_mm / 2,
                      .depth_mm = slide.depth_mm,
                      .pad = pad_of_tip,
                      .direction_deg = slide.direction_deg,
                      .speed_mm_per_s = slide.speed_mm_per_s,
                      .press = {.rise_s = 0.05}}};
    return fingertip_on(std::move(touch), slide.seed);
}

// By patch, without the first window.
using Told = std::vector<PatchTexture>[2];

void read_out(const Plan& plan, Told& told) {
    whole_run(plan, {.step = [&](const ControllerStep& step) {
                  for (const PatchReadout& readout : step.readouts)
                      if (const auto* texture = std::get_if<PatchTexture>(&readout))
                          if (texture->end > scene_start + 600ms)
                              told[texture->patch.value].push_back(*texture);
              }});
}

double angle_between(double one_deg, double other_deg) {
    return std::abs(std::remainder(one_deg - other_deg, 360));
}

struct Errors {
    int windows = 0, told = 0, wrong = 0;
    double period = 0, bias = 0, speed = 0, direction_deg = 0;  // sums of squares, but for the bias
    int period_within = 0, speed_within = 0;
    double roughness_hz = 0;  // its sum

    // A period that is off by a quarter is another wave.
    void add(const PatchTexture& texture, const Grated& truth) {
        ++windows;
        const TextureEstimate& found = texture.estimate;
        roughness_hz += found.roughness_hz;
        if (!found.slides) return;
        const double off = found.period_mm / truth.period_mm - 1;
        if (std::abs(off) > 0.25) {
            ++wrong;
            return;
        }
        ++told;
        period += off * off;
        bias += off;
        speed += std::pow(found.speed_mm_per_s / truth.speed_mm_per_s - 1, 2);
        direction_deg += std::pow(angle_between(found.direction_deg, truth.direction_deg), 2);
        period_within += std::abs(off) < 2 * found.period_sigma_mm / truth.period_mm;
        speed_within +=
            std::abs(found.speed_mm_per_s - truth.speed_mm_per_s) < 2 * found.speed_sigma_mm_per_s;
    }
    double rms(double sum) const { return std::sqrt(sum / told); }
    // 75 % correct in a choice of two intervals: d' = √2 Φ⁻¹(0.75).
    double discriminated() const { return 0.954 * rms(period); }
    // Three binomial standard deviations less than 95 %.
    double least_within_two() const { return told * 0.95 - 3 * std::sqrt(told * 0.95 * 0.05); }
    void print(const std::string& name) const {
        std::printf(
            "%-34s told %3d of %3d, wrong %d  period %4.1f %% (mean %+4.1f)  speed %4.1f %%  direction %.1f  "
            "within two sigmas %3.0f %%, %3.0f %%  told apart %4.1f %%  roughness %4.1f Hz\n",
            name.c_str(), told, windows, wrong, 100 * rms(period), 100 * bias / told, 100 * rms(speed),
            rms(direction_deg), 100.0 * period_within / told, 100.0 * speed_within / told,
            100 * discriminated(), roughness_hz / windows);
    }
};

struct World {
    std::function<void(Scene&)> scene = {};
    std::function<void(Plan&)> plan = {};
};

// Gratings of one period at two speeds and in many directions, on as many fingertips.
void slide(const std::string& name, double period_mm, int count, Errors (&errors)[2], const World& world = {},
           std::uint64_t first_seed = 1) {
    for (int i = 0; i < count; ++i) {
        const Grated truth{.period_mm = period_mm,
                           .speed_mm_per_s = i % 2 ? 30.0 : 70.0,
                           .direction_deg = std::fmod(31 * period_mm + 137.5 * i, 360),
                           .seed = first_seed + static_cast<std::uint64_t>(i)};
        Scene scene = fingertip_on(truth);
        if (world.scene) world.scene(scene);
        Plan plan = make_plan(scene);
        if (world.plan) world.plan(plan);
        Told told;
        read_out(plan, told);
        for (int kind = 0; kind < 2; ++kind)
            for (const PatchTexture& texture : told[kind]) errors[kind].add(texture, truth);
    }
    for (int kind = 0; kind < 2; ++kind) errors[kind].print(name + ", " + kinds_of_tip[kind]);
}

TEST(Textures, AreToldByTheirPeriodAndSpeed) {
    for (const double period_mm : {1.3, 1.6, 2.0, 3.0, 4.5}) {
        char name[40];
        std::snprintf(name, sizeof name, "grating of %.1f mm", period_mm);
        Errors errors[2];
        slide(name, period_mm, long_runs ? 6 : 2, errors);
        for (int kind = 0; kind < 2; ++kind) {
            EXPECT_EQ(errors[kind].wrong, 0) << name;
            // RA feel too little of ridges that are no wider than their fields.
            if (kind == 0 || period_mm > 1.5) {
                EXPECT_EQ(errors[kind].told, errors[kind].windows) << name;
            }
            // What people tell apart of a period near 1 mm.
            EXPECT_LT(errors[kind].discriminated(), 0.05) << name;
            EXPECT_GE(errors[kind].period_within, errors[kind].least_within_two()) << name;
            EXPECT_GE(errors[kind].speed_within, errors[kind].least_within_two()) << name;
        }
    }
}

TEST(Textures, AreToldInAWorldThatIsNotAsTold) {
    // The largest error of a period that each is allowed.
    const auto in = [](const char* name, double most, const World& world) {
        Errors errors[2];
        slide(name, 2, long_runs ? 4 : 1, errors, world, 41);
        for (const Errors& each : errors) {
            EXPECT_EQ(each.wrong, 0) << name;
            EXPECT_GT(each.told, 0) << name;
            EXPECT_LT(each.rms(each.period), most) << name;
        }
    };
    in("2 mm, nothing wrong", 0.02, {});
    in("10 % of packets lost", 0.02, {.scene = [](Scene& scene) {
           scene.link.transport = scene::Udp();
           scene.link.channel.emplace().loss = 0.1;
       }});
    in("tick of 1 ms", 0.02, {.scene = [](Scene& scene) { scene.link.tick_us = 1000; }});
    in("noise_mv: 2", 0.02, {.scene = [](Scene& scene) {
           for (auto& patch : scene.patches) patch.neuron.noise_mv = 2;
       }});
    in("a third of the skin dead", 0.05, {.scene = [](Scene& scene) {
           for (std::uint32_t i = 0; i < 140; ++i) scene.patches[0].sensor.dead_element.push_back(i);
       }});
    in("told places 10 % too far apart", 0.13, {.plan = [](Plan& plan) {
           for (auto& parameters : plan.controller->readouts.parameters)
               for (auto& afferent : std::get<TextureReadout::Parameters>(parameters).afferents) {
                   afferent.field.x_mm *= 1.1;
                   afferent.field.y_mm *= 1.1;
               }
       }});
    in("speed rises by a half in between", 0.03, {.scene = [](Scene& scene) {
           scene::Touch touch = std::get<scene::Touch>(scene.source);
           scene::Grating faster = touch.grating[0];
           touch.grating[0].press = {.rise_s = 0.05, .hold_s = 0.7, .fall_s = 0.02};
           faster.speed_mm_per_s *= 1.5;
           faster.press = {.begin_s = 0.75, .rise_s = 0.02};
           touch.grating.push_back(faster);
           scene.source = touch;
       }});
}

// Sums over the SA1 and the RA, and over all windows of the SA1.
struct Summed {
    int periods = 0;
    double roughness_hz = 0;
    double roughness_of_sa1_hz = 0;
};
Summed periods_told(scene::Touch touch, int scenes, const char* name) {
    int told_of[2]{}, windows = 0;
    double roughness[2]{};
    for (int i = 0; i < scenes; ++i) {
        for (scene::Texture& texture : touch.texture) {
            texture.seed = static_cast<std::uint32_t>(i + 1);
            texture.direction_deg = (77 * i) % 360;
        }
        for (scene::Dots& dots : touch.dots) dots.direction_deg = (77 * i) % 360;
        Told told;
        read_out(make_plan(fingertip_on(touch, static_cast<std::uint64_t>(71 + i))), told);
        for (int kind = 0; kind < 2; ++kind)
            for (const PatchTexture& texture : told[kind]) {
                told_of[kind] += texture.estimate.slides;
                roughness[kind] += texture.estimate.roughness_hz;
                windows += kind == 0;
            }
    }
    for (int kind = 0; kind < 2; ++kind)
        std::printf("%-34s a period in %d of %d windows  roughness %.1f Hz\n",
                    (std::string(name) + ", " + kinds_of_tip[kind]).c_str(), told_of[kind], windows,
                    roughness[kind] / windows);
    return {told_of[0] + told_of[1], roughness[0] + roughness[1], roughness[0]};
}

TEST(Textures, HaveNoPeriodIfTheyDoNotSlide) {
    const int scenes = long_runs ? 4 : 1;
    scene::Touch held;
    held.grating = {{.pad = pad_of_tip, .speed_mm_per_s = 0, .press = {.rise_s = 0.05}}};
    EXPECT_EQ(periods_told(held, scenes, "grating of 2 mm, held").periods, 0);
    scene::Touch vibrates;
    vibrates.indenter = {
        {.radius_mm = 6, .force_n = 0.3, .press = {.rise_s = 0.05, .vibration_hz = 30, .vibration = 0.3}}};
    EXPECT_EQ(periods_told(vibrates, scenes, "sphere that vibrates").periods, 0);
}

TEST(Textures, GetRougherWithTheirHeight) {
    double least_hz = 0;
    for (const double rms_mm : {0.05, 0.1, 0.2}) {
        scene::Touch touch;
        scene::Texture& texture = touch.texture.emplace_back();
        texture.rms_mm = rms_mm;
        texture.pad = pad_of_tip;
        texture.speed_mm_per_s = 40;
        texture.press.rise_s = 0.05;
        char name[40];
        std::snprintf(name, sizeof name, "random texture of %.2f mm", rms_mm);
        const double roughness_hz = periods_told(touch, long_runs ? 4 : 1, name).roughness_hz;
        EXPECT_GT(roughness_hz, least_hz) << name;
        least_hz = roughness_hz;
    }
}

// Dots under the force with which the pad presses a smooth surface at 20 kPa. The fewer dots there are, the
// deeper the skin sinks between them, so that the pressure on them is higher by that of their height on the
// rest of the skin.
scene::Touch on_dots(double spacing_mm, double speed_mm_per_s) {
    scene::Touch touch;
    scene::Dots& dots = touch.dots.emplace_back();
    dots.spacing_mm = spacing_mm;
    dots.pad = pad_of_tip;
    const double covered = std::numbers::pi * std::pow(dots.diameter_mm / 2 / spacing_mm, 2);
    dots.pad.peak_kpa += (1 - covered) * dots.pad.stiffness_kpa_per_mm * dots.depth_mm;
    dots.speed_mm_per_s = speed_mm_per_s;
    dots.press.rise_s = 0.05;
    return touch;
}

// Readings by other afferents of other pieces of the same kind of surface differ by as much as each of them
// says.
TEST(Textures, HaveARoughnessThatVariesAsItSays) {
    int within = 0, readings = 0;
    const auto compare = [&](const std::string& name, const std::function<scene::Touch(int)>& touch) {
        const int scenes = long_runs ? 12 : 3;
        std::vector<TextureEstimate> all[2];
        for (int i = 0; i < scenes; ++i) {
            Told told;
            read_out(make_plan(fingertip_on(touch(i), static_cast<std::uint64_t>(101 + i))), told);
            for (int kind = 0; kind < 2; ++kind) all[kind].push_back(told[kind].front().estimate);
        }
        for (int kind = 0; kind < 2; ++kind) {
            double mean_hz = 0, squares = 0, variance = 0;
            for (const TextureEstimate& each : all[kind]) {
                mean_hz += each.roughness_hz / scenes;
                variance += each.roughness_sigma_hz * each.roughness_sigma_hz / scenes;
            }
            int within_two = 0;
            for (const TextureEstimate& each : all[kind]) {
                const double off_hz = std::abs(each.roughness_hz - mean_hz);
                squares += off_hz * off_hz;
                within_two += off_hz < 2 * each.roughness_sigma_hz;
            }
            within += within_two;
            readings += scenes;
            std::printf(
                "%-34s roughness %.1f Hz, varies by %.2f Hz, told %.2f Hz, within two sigmas %d of %d\n",
                (name + ", " + kinds_of_tip[kind]).c_str(), mean_hz, std::sqrt(squares / (scenes - 1)),
                std::sqrt(variance), within_two, scenes);
        }
    };
    for (const double rms_mm : {0.05, 0.2})
        compare("random texture of " + std::string(rms_mm < 0.1 ? "0.05" : "0.20") + " mm", [=](int i) {
            scene::Touch touch;
            scene::Texture& texture = touch.texture.emplace_back();
            texture.rms_mm = rms_mm;
            texture.seed = static_cast<std::uint32_t>(i + 1);
            texture.direction_deg = (77 * i) % 360;
            texture.pad = pad_of_tip;
            texture.speed_mm_per_s = 40;
            texture.press.rise_s = 0.05;
            return touch;
        });
    compare("grating of 3 mm", [](int i) {
        return std::get<scene::Touch>(
            fingertip_on(Grated{.period_mm = 3, .direction_deg = std::fmod(77.0 * i, 360)}).source);
    });
    compare("dots 2.5 mm apart", [](int i) {
        scene::Touch touch = on_dots(2.5, 20);
        touch.dots[0].direction_deg = (77 * i) % 360;
        return touch;
    });
    if (!long_runs) return;  // which have too few readings
    // Four binomial standard deviations less than 95 %.
    EXPECT_GE(within, 0.95 * readings - 4 * std::sqrt(0.95 * 0.05 * readings));
    EXPECT_LT(within, readings) << "and no larger than it has to be";
}

// As people report it, and as the spatial variation of their SA1 goes (Connor et al. 1990): roughness grows
// with the spacing of dots, and falls again where there are few of them.
TEST(Textures, AreRoughestAtSomeSpacingOfDots) {
    const auto roughness_hz = [](double spacing_mm, double speed_mm_per_s) {
        char name[60];
        std::snprintf(name, sizeof name, "dots %.1f mm apart, %.0f mm/s", spacing_mm, speed_mm_per_s);
        return periods_told(on_dots(spacing_mm, speed_mm_per_s), long_runs ? 4 : 2, name).roughness_of_sa1_hz;
    };
    const std::vector<double> spacings_mm =
        long_runs ? std::vector{1.3, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0, 6.2} : std::vector{1.3, 2.5, 6.2};
    std::vector<double> each_hz;
    for (const double spacing_mm : spacings_mm) each_hz.push_back(roughness_hz(spacing_mm, 20));
    const auto most = std::ranges::max_element(each_hz);
    EXPECT_NEAR(spacings_mm[static_cast<std::size_t>(most - each_hz.begin())], 2.85, 0.36);
    EXPECT_GT(*most, 2 * each_hz.front());
    EXPECT_GT(*most, 1.2 * each_hz.back());
    // Too fast for intervals of a tenth of a second: printed, and bounded by nothing.
    if (long_runs)
        for (const double spacing_mm : {1.3, 2.5, 4.0, 6.2}) (void)roughness_hz(spacing_mm, 50);
}

}  // namespace
}  // namespace afferent
