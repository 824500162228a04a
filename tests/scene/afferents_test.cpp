// Afferents at places of their own that differ from each other.
#include "afferent/scene/afferents.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <numeric>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/hand/disc_contact.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/scene/patch.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr const char* silent_records = " source { pushed {} } record { force: false picture: false }";

Scene skin(const std::string& patch, const std::string& rest = silent_records) {
    return Scene::from_text(
        "patch { name: 'skin' outline { rectangle { width_mm: 5 height_mm: 4 } pitch_mm: 0.5 } " + patch +
        " }" + rest);
}

std::string why_refused(const std::string& text) {
    try {
        Scene::from_text(text);
    } catch (const SceneError& error) {
        return error.what();
    }
    return "accepted";
}

// The events of a second in which the pressure varies over skin and time.
std::vector<Event> events_under_touch(const Scene& scene) {
    const Plan plan = make_plan(scene);
    Coprocessor coprocessor(plan);
    std::vector<double> forces_n(plan.elements);
    std::vector<Event> events;
    for (std::uint64_t i = 0; i < 200; ++i) {
        for (std::size_t k = 0; k < forces_n.size(); ++k)
            forces_n[k] = 0.01 * (1 + std::sin(0.1 * static_cast<double>(i) + 0.37 * static_cast<double>(k)));
        coprocessor.push({sample_time(i, 200), 0, forces_n});
        const auto more = coprocessor.advance(sample_time(i + 1, 200) - Duration(1));
        events.insert(events.end(), more.begin(), more.end());
    }
    return events;
}

TEST(Afferents, LieInTheOutlineInTheirDensity) {
    const Plan plan = make_plan(skin("afferents { per_cm2: 200 jitter: 0.5 }"));
    EXPECT_EQ(plan.elements, 10U * 8U);
    EXPECT_EQ(plan.patches.at(0).afferents(), 40U);
    EXPECT_EQ(plan.patches.at(0).places.size(), 40U);
    // Those in the middle read a uniform pressure of 1 N/mm² as 1 N.
    const std::vector<double> uniform(plan.elements, 0.25);
    EXPECT_NEAR(make_plan(skin("afferents { field_sd_mm: 0.4 place { x_mm: 0.1 } }"))
                    .patches[0]
                    .fields.sum(0, uniform),
                1, 1e-12);
}

// The mean of Hertz's pressure under a Gaussian field, as a sum over the contact, whatever the pitch: the
// field that was asked for, or that of 0.78 pitches if that is wider.
TEST(Afferents, ReadTheMeanPressureUnderTheirField) {
    constexpr double a_mm = 1.3;
    const Position contact{0.4, -0.3};
    for (const double field_sd_mm : {0.5, 1.0, 3.0})
        for (const double pitch_mm : {0.25, 0.5, 1.0}) {
            const Plan plan = make_plan(Scene::from_text(
                "patch { name: 'a' outline { rectangle { width_mm: 24 height_mm: 24 } pitch_mm: " +
                std::to_string(pitch_mm) + " } afferents { field_sd_mm: " + std::to_string(field_sd_mm) +
                " place { x_mm: 0.1 } } }" + std::string(silent_records)));
            const ElementGrid& grid = *plan.patches[0].grid;
            const DiscContact sphere{DiscContact::Tip::sphere, contact.x_mm, contact.y_mm, a_mm, 2,
                                     Aperture(pitch_mm)};
            std::vector<double> forces_n;
            for (std::uint32_t i = 0; i < grid.elements(); ++i)
                forces_n.push_back(sphere.force_n({grid.place(i).x_mm, grid.place(i).y_mm}));
            const double sd_mm = std::max(field_sd_mm, 0.78 * pitch_mm);
            double expected_n = 0;
            constexpr int steps = 100;
            for (int i = 0; i < steps; ++i)
                for (int k = 0; k < steps; ++k) {
                    // Equal steps of the angles: r = a sin(polar).
                    const double polar = std::numbers::pi / 2 * (i + 0.5) / steps;
                    const double angle = 2 * std::numbers::pi * (k + 0.5) / steps;
                    const double x_mm = contact.x_mm + a_mm * std::sin(polar) * std::cos(angle) - 0.1;
                    const double y_mm = contact.y_mm + a_mm * std::sin(polar) * std::sin(angle);
                    const double part = 3 * std::pow(std::cos(polar), 2) * std::sin(polar) *
                                        std::numbers::pi / 2 / (steps * steps);
                    expected_n += 2 * part * std::exp(-(x_mm * x_mm + y_mm * y_mm) / (2 * sd_mm * sd_mm)) /
                                  (2 * std::numbers::pi * sd_mm * sd_mm);
                }
            // The field is cut at three deviations of its weights, and the narrowest has a dozen of them.
            EXPECT_NEAR(plan.patches[0].fields.sum(0, forces_n), expected_n, 0.03 * expected_n)
                << field_sd_mm << ' ' << pitch_mm;
        }
}

TEST(Afferents, ReadTheElementsOfAnotherPatch) {
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'a' kind: SA1 outline { ellipse { width_mm: 15 height_mm: 9 } } } "
        "patch { name: 'b' kind: RA elements_of: 'a' } patch { name: 'c' kind: PC elements_of: 'a' }" +
        std::string(silent_records)));
    // 70, 140 and 25 on 1.06 cm².
    EXPECT_NEAR(plan.patches.at(0).afferents(), 74, 4);
    EXPECT_NEAR(plan.patches.at(1).afferents(), 148, 6);
    EXPECT_NEAR(plan.patches.at(2).afferents(), 26.5, 3);
    EXPECT_NE(plan.patches.at(1).places, plan.patches.at(0).places);
    EXPECT_EQ(plan.patches.at(1).elements(), plan.elements);
    EXPECT_FALSE(plan.controller);
}

TEST(Afferents, TakeTheirPlacesFromATable) {
    const auto folder =
        std::filesystem::temp_directory_path() / ("afferent_places_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "places.csv") << "name,x_mm,y_mm\na,1.5,-0.25\nb,-2,1e0\n";
    const std::string text =
        "patch { name: 'skin' outline {} afferents { places: 'places.csv' } }" + std::string(silent_records);
    const Scene scene = Scene::from_text(text, "scene", folder);
    EXPECT_EQ(make_plan(scene).patches.at(0).places, (std::vector<Position>{{1.5, -0.25}, {-2, 1}}));
    // What is written stands alone.
    EXPECT_EQ(Scene::from_text(scene.text()).patches, scene.patches);
    std::ofstream(folder / "places.csv") << "x_mm,y_mm\n1,2\n3,far\n";
    try {
        Scene::from_text(text, "scene", folder);
        ADD_FAILURE() << "accepted";
    } catch (const SceneError& error) {
        EXPECT_NE(std::string(error.what()).find("places.csv:3: \"far\" is no number"), std::string::npos)
            << error.what();
    }
    std::filesystem::remove_all(folder);
    EXPECT_NE(why_refused(text).find("places.csv"), std::string::npos);
}

TEST(Afferents, AreRefusedWithTheFieldAndTheRule) {
    const std::string outline = "patch { name: 'a' outline {} ";
    for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
             {"patch { name: 'a' kind: SA1 }", "need an outline"},
             {outline + "elements: 5 }", "elements follows from the outline, 100, and is given as 5"},
             {outline + "afferents {} field { weight {} } }", "either fields or afferents"},
             {outline + "afferents { place { x_mm: 6 } } }", "afferents.place must be within the outline"},
             {outline + "} patch { name: 'b' elements_of: 'a' outline {} }", "has no outline of its own"},
             {outline + "spread { gain { normal { sd: 0.3 } } } }",
              "spread.gain must be > 0 in all its values"},
             {outline + "spread { gain { uniform { lowest: 2 } } } }",
              "spread.gain.uniform.highest must be >= lowest"},
             {outline + "spread { threshold { uniform { lowest: 1e-300 highest: 1e-300 } } } }", "v_r_mv"},
             {outline + "encoder { vibration {} } }", "gain_mv_s2_per_n must be given"},
             {"patch { name: 'a' } source { edge {} }", "outline must be given where stimuli"},
             {outline + "encoder { transient { corner_hz: 50 } } } decoder { filter {} patch: 'a' }",
              "no corner frequency"},
         })
        EXPECT_NE(why_refused(text).find(expected), std::string::npos) << text << "\n" << why_refused(text);
}

// What a patch gives itself is first, then every_patch, then the kind.
TEST(Kinds, AreUnderWhatTheSceneSays) {
    const Scene scene = Scene::from_text(
        "every_patch { neuron { tau_m_ms: 7 tau_g_ms: 70 } } "
        "patch { name: 'a' kind: RA outline {} neuron { tau_g_ms: 100 } spread { gain { normal { sd: 0.1 } } "
        "} }" +
        std::string(silent_records));
    const scene::Patch& patch = scene.patches[0];
    const scene::Patch preset = scene::preset(scene::Kind::ra);
    EXPECT_EQ(patch.neuron.tau_m_ms, 7);
    EXPECT_EQ(patch.neuron.tau_g_ms, 100);
    EXPECT_EQ(patch.neuron.delta_g, preset.neuron.delta_g);
    EXPECT_EQ(patch.encoder, preset.encoder);
    EXPECT_EQ(patch.afferents, preset.afferents);
    EXPECT_EQ(patch.spread.gain, scene::Distribution(scene::Normal{.mean = 1, .sd = 0.1}));
    EXPECT_EQ(patch.spread.phase, preset.spread.phase);
    EXPECT_EQ(scene.text().find(" kind:"), std::string::npos) << "the scene has the numbers instead";
    EXPECT_NE(scene.text().find("of_kind: RA"), std::string::npos) << "and the name";
    EXPECT_EQ(Scene::from_text(scene.text()).patches, scene.patches);
}

// Densities at the fingertip: docs/afferents.md has their sources.
TEST(Kinds, HaveTheDensitiesOfAFingertipAndPhasesThatAreAsEvenAsTheyCanBe) {
    const std::pair<scene::Kind, double> per_cm2[]{
        {scene::Kind::sa1, 70}, {scene::Kind::ra, 140}, {scene::Kind::pc, 25}};
    for (const auto& [kind, density] : per_cm2) {
        const scene::Patch patch = scene::preset(kind);
        EXPECT_EQ(patch.afferents.value().per_cm2, density);
        EXPECT_EQ(patch.spread.phase, scene::Distribution(scene::Uniform{.lowest = 0, .highest = 1}));
    }
}

// Several kinds in one skin stand for a patch of each.
TEST(Kinds, ShareASkin) {
    const Scene scene = Scene::from_text(
        "every_patch { kinds: [SA1, RA, PC] sensor { rate_hz: 500 } outline { pitch_mm: 0.5 } } "
        "patch { name: 'tip' outline { centre { x_mm: 5 } } } "
        "patch { name: 'palm' kinds: [SA1, PC] per_cm2: [10, 20] outline { rectangle { width_mm: 40 } } } "
        "patch { name: 'hairs' kind: RA }" +
        std::string(silent_records));
    std::vector<std::string> names;
    for (const scene::Patch& patch : scene.patches) names.push_back(patch.name);
    EXPECT_EQ(names,
              (std::vector<std::string>{"tip SA1", "tip RA", "tip PC", "palm SA1", "palm PC", "hairs"}));
    EXPECT_EQ(scene.patches.at(1).elements_of, "tip SA1");
    EXPECT_EQ(scene.patches.at(1).encoder, scene::preset(scene::Kind::ra).encoder);
    EXPECT_FALSE(scene.patches.at(1).outline);
    EXPECT_EQ(scene.patches.at(3).afferents->per_cm2, 10);
    EXPECT_EQ(scene.patches.at(4).afferents->per_cm2, 20);
    EXPECT_EQ(scene.patches.at(4).afferents->field_sd_mm, 3.27);
    const Plan plan = make_plan(scene);
    EXPECT_EQ(plan.patches.at(2).centre, (Position{5, 0}));
    EXPECT_EQ(plan.patches.at(2).sensor.rate_hz, 500);
    EXPECT_NEAR(plan.patches.at(4).afferents(), 80, 4);
    EXPECT_EQ(Scene::from_text(scene.text()).patches, scene.patches);
}

TEST(Kinds, AreRefusedWhereTheyWereWritten) {
    for (const auto& [text, expected] : std::vector<std::pair<std::string, std::string>>{
             {"patch { name: 'a' kinds: SA1 kind: RA outline {} }", "1:19: patch \"a\": a patch has either"},
             {"patch { name: 'a' kinds: [SA1, RA] per_cm2: 5 outline {} }",
              "1:36: patch \"a\": per_cm2 must be given once for each of the 2 kinds, is given 1 times"},
             {"patch { name: 'a' kinds: [SA1, RA] outline {} }\n"
              "patch { name: 'b' outline {} neuron { tau_m_ms: -1 } }",
              "2:39: patch \"b\": neuron.tau_m_ms must be"},
             {"patch { name: 'a' kinds: [RA, RA] outline {} }", "another patch has this name"},
         })
        EXPECT_NE(why_refused(text).find(expected), std::string::npos) << text << "\n" << why_refused(text);
}

// ---- differences ----

TEST(Spread, HasTheMomentsOfItsDistributions) {
    scene::Spread spread{.threshold = scene::Normal{.mean = 1.2, .sd = 0.1},
                         .delta_g = scene::LogNormal{.median = 2, .sigma = 0.5},
                         .phase = scene::Uniform{.lowest = 0.2, .highest = 0.6},
                         .time_class = {{.part = 3}, {.part = 1}}};
    constexpr std::uint32_t count = 20'000;
    const auto variations = variations_of(spread, count, {1, 500});
    const Phases phases = phases_of(spread, {1, 500});
    const auto moments = [&](auto&& value) {
        double sum = 0;
        double squares = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            const double own = value(i);
            sum += own;
            squares += own * own;
        }
        const double mean = sum / count;
        return std::pair(mean, std::sqrt(squares / count - mean * mean));
    };
    // A mean strays by sd/√n = 0.7 % of the deviation, and a deviation by 1/√(2n); four of those, and the cut
    // at four deviations takes less.
    const auto expect = [&](auto&& value, double mean, double sd) {
        const auto [found_mean, found_sd] = moments(value);
        EXPECT_NEAR(found_mean, mean, 4 * sd / std::sqrt(count));
        EXPECT_NEAR(found_sd, sd, 4 * sd / std::sqrt(2.0 * count));
    };
    expect([&](std::uint32_t i) { return variations[i].threshold; }, 1.2, 0.1);
    expect([&](std::uint32_t i) { return std::log(variations[i].delta_g / 2); }, 0, 0.5);
    expect(phases, 0.4, 0.4 / std::sqrt(12));
    expect([&](std::uint32_t i) { return variations[i].time_class; }, 0.25, std::sqrt(0.25 * 0.75));
}

// An afferent's own number follows from its address, in whatever patch that is.
TEST(Spread, FollowsTheAddress) {
    const scene::Spread spread{.threshold = scene::Normal{.mean = 1, .sd = 0.1}};
    const auto whole = variations_of(spread, 10, {1, 100});
    const auto later = variations_of(spread, 4, {1, 106});
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(later.at(i).threshold, whole.at(6 + i).threshold);
    EXPECT_NE(variations_of(spread, 1, {2, 100}).at(0).threshold, whole.at(0).threshold);
    EXPECT_EQ(whole.at(0).delta_g, 1) << "which is not spread";
    EXPECT_TRUE(variations_of({}, 10, {1, 100}).empty());
}

TEST(Spread, GivesTheSameEventsForAnyThreads) {
    Scene scene = skin(
        "afferents { per_cm2: 20000 jitter: 1 field_sd_mm: 0.3 } encoder { sustained { gain_mv_per_n: 900 } "
        "} "
        "spread { gain { log_normal { sigma: 0.3 } } phase { uniform { lowest: 0 } } "
        "threshold { normal { sd: 0.05 } } time_class { tau_m: 0.5 } time_class { tau_g: 2 } }");
    const auto expected = events_under_touch(scene);
    EXPECT_GT(expected.size(), 10'000U);
    for (const std::uint32_t threads : {2, 3}) {
        scene.runtime.threads = threads;
        EXPECT_GT(make_plan(scene).shards.size(), 1U);
        EXPECT_EQ(events_under_touch(scene), expected) << threads;
    }
}

TEST(Spread, GivesTheSameEventsInBothForms) {
    const auto events = [](const std::string& form) {
        // Clocked, so that the dense form is allowed.
        const Scene scene =
            skin("elements: 80 encoder { sustained { gain_mv_per_n: 5000 } } neuron { form: " + form +
                     " refractory_ms: 1 } spread { gain { log_normal { sigma: 0.3 } } "
                     "phase { uniform { lowest: 0 } } threshold { normal { sd: 0.05 } } "
                     "delta_g { log_normal { sigma: 0.5 } } }",
                 " source { profile { point { force_n: 1 } } } record { force: false picture: false }");
        EXPECT_EQ(make_plan(scene).patches.at(0).form == scene::Form::dense, form == "DENSE");
        std::vector<Event> all = events_under_touch(scene);
        std::sort(all.begin(), all.end(), [](const Event& a, const Event& b) {
            return std::pair(a.address, a.time) < std::pair(b.address, b.time);
        });
        return all;
    };
    const auto sparse = events("SPARSE");
    const auto dense = events("DENSE");
    ASSERT_EQ(sparse.size(), dense.size());
    EXPECT_GT(sparse.size(), 1000U);
    for (std::size_t i = 0; i < sparse.size(); ++i) {
        ASSERT_EQ(sparse[i].address, dense[i].address);
        ASSERT_LE(std::chrono::abs(sparse[i].time - dense[i].time), Duration(1));
    }
}

// Alike afferents under a uniform pressure fire at the same instants; those that differ do not.
TEST(Spread, KeepsAPopulationFromFiringAsOne) {
    const auto distinct_times = [](const std::string& spread) {
        const Plan plan = make_plan(skin("encoder { sustained { gain_mv_per_n: 2000 } } " + spread));
        Coprocessor coprocessor(plan);
        coprocessor.push({scene_start, 0, std::vector<double>(plan.elements, 0.05)});
        std::vector<TimePoint> times;
        for (const Event& event : coprocessor.advance(scene_start + 500ms)) times.push_back(event.time);
        const auto spikes = static_cast<double>(times.size());
        times.erase(std::unique(times.begin(), times.end()), times.end());
        return static_cast<double>(times.size()) / spikes;
    };
    EXPECT_DOUBLE_EQ(distinct_times(""), 1.0 / 80);
    for (const char* spread :
         {"spread { gain { normal { sd: 0.1 } } }", "spread { threshold { normal { sd: 0.1 } } }",
          "spread { phase { uniform { lowest: 0 } } }"})
        EXPECT_GT(distinct_times(spread), 0.99) << spread;
}

// Only then does each of them need a neuron of its own.
TEST(Spread, OfThresholdIncreaseOrTimeMakesNeuronsDiffer) {
    const auto differ = [](const std::string& spread) {
        return make_plan(
                   Scene::from_text("gain { accept_unreachable_limit: true } patch { name: 'a' elements: 4 " +
                                    spread + " }"))
            .patches[0]
            .neurons_differ;
    };
    for (const char* alike :
         {"", "spread { gain { normal { sd: 0.1 } } }", "spread { phase { uniform { lowest: 0 } } }"})
        EXPECT_FALSE(differ(alike)) << alike;
    for (const char* unlike :
         {"spread { threshold { normal { sd: 0.1 } } }", "spread { delta_g { normal { sd: 0.1 } } }",
          "spread { time_class { tau_m: 1 } time_class { tau_m: 2 } }"})
        EXPECT_TRUE(differ(unlike)) << unlike;
}

// Decoders are told each afferent's own neuron and share.
TEST(Spread, IsKnownToDecoders) {
    const Plan plan = make_plan(
        Scene::from_text("patch { name: 'a' elements: 4 encoder { sustained { gain_mv_per_n: 10 } } "
                         "spread { gain { normal { sd: 0.1 } } threshold { normal { sd: 0.1 } } } }"));
    const DecodedAfferents& decoded = plan.controller.value().afferents;
    ASSERT_EQ(decoded.groups.size(), 4U);
    ASSERT_EQ(decoded.afferents.size(), 4U);
    for (std::uint32_t i = 0; i < 4; ++i) {
        const PatchPlan& patch = plan.patches[0];
        const DecodedAfferents::Group& group = decoded.groups.at(decoded.afferents[i].group);
        EXPECT_EQ(std::get<LifParameters>(group.neuron).v_th_mv,
                  std::get<LifParameters>(patch.neuron_of(i)).v_th_mv);
        EXPECT_NE(patch.neuron_of(i), patch.neuron);
        EXPECT_DOUBLE_EQ(group.drive_mv_per_n, 10 * patch.fields.row(i)[0].weight / 4);
    }
}

TEST(Spread, OfAClassChangesBothTimeConstants) {
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'a' elements: 4 neuron { tau_m_ms: 8 tau_g_ms: 40 } encoder { sustained "
        "{ gain_mv_per_n: 10 } } spread { time_class { tau_m: 0.5 tau_g: 3 } } }"));
    for (std::uint32_t i = 0; i < 4; ++i) {
        const auto neuron = std::get<LifParameters>(plan.patches[0].neuron_of(i));
        EXPECT_EQ(neuron.tau_m_ms, 4);
        EXPECT_EQ(neuron.tau_g_ms, 120);
    }
}

TEST(Spread, IsToldByThePlan) {
    const auto part = [](const Plan& plan, const std::string& name) {
        const auto found = std::find_if(plan.items.begin(), plan.items.end(),
                                        [&](const PlanItem& each) { return each.name.ends_with(name); });
        return found == plan.items.end() ? PlanItem{} : *found;
    };
    const Plan alike = make_plan(skin(""));
    EXPECT_FALSE(part(alike, ": spread").built);
    EXPECT_TRUE(part(alike, "two dimensions").built);
    const Plan differing = make_plan(skin("kind: PC"));
    EXPECT_TRUE(part(differing, ": spread").built);
    EXPECT_EQ(part(differing, ": spread").reason, "afferents differ in gain, phase");
    EXPECT_TRUE(part(differing, "vibration encoder").built);
    EXPECT_GT(differing.bytes_per_neuron, alike.bytes_per_neuron) << "each has numbers of its own";
}

}  // namespace
}  // namespace afferent
