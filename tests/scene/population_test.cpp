// What a scene tells others of its afferents.
#include "afferent/scene/population.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/scene/patch.hpp"

namespace afferent {
namespace {

const char* const skin_of_two =
    "duration_s: 1 record { force: false } source { edge {} } "
    "patch { name: 'skin' kind: SA1 outline { rectangle { width_mm: 4 height_mm: 2 } pitch_mm: 1 } "
    "        afferents { place { x_mm: 1.4 y_mm: 0.4 } place { x_mm: -1.5 y_mm: -0.5 } field_sd_mm: 0.2 } } "
    "patch { name: 'again' elements_of: 'skin' encoder { sustained { gain_mv_per_n: 1 } } }";

TEST(PopulationOfAPlan, HasPatchKindPlaceAndElementsOfEachAfferent) {
    const Population population = population_of(make_plan(Scene::from_text(skin_of_two)));
    EXPECT_EQ(population.patches,
              (std::vector<Population::Patch>{{"skin", 2, "SA1"}, {"again", 8, "sustained"}}));
    ASSERT_EQ(population.afferents.size(), 10U);
    // Rows from the lowest y, each from the lowest x: the first place is in the last cell, the second in the
    // first.
    EXPECT_EQ(population.afferents.at(0).place, (Position{1.4, 0.4}));
    EXPECT_EQ(population.afferents.at(0).element, 7U);
    EXPECT_EQ(population.afferents.at(1).place, (Position{-1.5, -0.5}));
    EXPECT_EQ(population.afferents.at(1).element, 0U);
    // The weights of so narrow a field have a deviation of half a pitch and reach three of them: to the next
    // elements along both axes and the diagonal.
    EXPECT_EQ(population.afferents.at(1).elements, 4U);
    EXPECT_EQ(population.afferents.at(2).place, (Position{-1.5, -0.5}))
        << "an afferent for each element lies on it";
    EXPECT_EQ(population.afferents.at(9).place, (Position{1.5, 0.5}));
    EXPECT_EQ(population.afferents.at(9).element, 7U);
}

TEST(PopulationOfAPlan, HasNoPlacesWherePatchesHaveNoDimensions) {
    const Population population = population_of(make_plan(Scene::from_text(
        "patch { name: 'a' elements: 2 } patch { name: 'b' elements_of: 'a' encoder { transient {} } "
        "field { weight { element: 0 weight: 0.5 } weight { element: 1 weight: 2 } } }")));
    EXPECT_FALSE(population.has_positions());
    EXPECT_EQ(population.patches,
              (std::vector<Population::Patch>{{"a", 2, "sustained"}, {"b", 1, "transient"}}));
    EXPECT_EQ(population.afferents.at(2), (Population::Afferent{.element = 1, .elements = 2}));
}

TEST(PopulationOfAPlan, HasTheOutlineOfItsSkin) {
    const auto outline = [](const std::string& shape) {
        const Skin skin = skin_of(make_plan(
            Scene::from_text("duration_s: 1 record { force: false } source { edge {} } patch { name: 'skin' "
                             "outline { " +
                             shape + " { width_mm: 4 height_mm: 2 } pitch_mm: 1 } }")));
        EXPECT_EQ(skin.outlines.size(), 1U);
        return skin.outlines.at(0);
    };
    EXPECT_EQ(outline("rectangle"), (std::vector<Position>{{-2, -1}, {2, -1}, {2, 1}, {-2, 1}}));
    const std::vector<Position> corners = outline("ellipse");
    ASSERT_EQ(corners.size(), 90U);
    EXPECT_EQ(corners[0], (Position{2, 0}));
    double length_mm = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Position& at = corners[i];
        const Position& next = corners[(i + 1) % corners.size()];
        EXPECT_NEAR(at.x_mm * at.x_mm / 4 + at.y_mm * at.y_mm, 1, 1e-12) << i;
        length_mm += std::hypot(next.x_mm - at.x_mm, next.y_mm - at.y_mm);
    }
    // The circumference is 9.6884 mm; 90 chords take a thousandth from it.
    EXPECT_NEAR(length_mm, 9.6884, 0.01);
}

TEST(PopulationOfAPlan, KnowsWhichWayAStimulusMoves) {
    const auto direction_deg = [](const std::string& source) {
        return stimulus_direction_deg(Scene::from_text(
            "source { " + source + " } patch { name: 'skin' outline {} } record { force: false }"));
    };
    EXPECT_EQ(direction_deg("profile { point { force_n: 1 } }"), 0);
    EXPECT_EQ(direction_deg("edge { direction_deg: 30 }"), 30);
}

TEST(Variation, IsNoneByDefault) {
    EXPECT_EQ(Variation().threshold, 1);
    EXPECT_EQ(Variation().delta_g, 1);
    EXPECT_EQ(Variation().time_class, 0U);
}

// What an afferent of several elements may be thought to feel of the grip: never less than its most loaded
// one.
TEST(PatchPlan, HasTheLargestShareAmongTheElementsOfAnAfferent) {
    const Plan plan = make_plan(Scene::from_text(
        "patch { name: 'a' elements: 3 share: [0.2, 0.5, 0.3] } patch { name: 'b' elements_of: 'a' "
        "field { weight { element: 0 weight: 0.5 } weight { element: 2 weight: 2 } } }"));
    EXPECT_EQ(plan.patches.at(0).largest_share_of(1), 0.5);
    EXPECT_EQ(plan.patches.at(1).largest_share_of(0), 0.3);
}

// A name is no number: two ends whose scenes differ in it alone talk to each other.
TEST(Kind, StaysWithTheSceneAndItsTextButNotInItsFingerprint) {
    const Scene scene = Scene::from_text(skin_of_two);
    EXPECT_EQ(scene.patches.at(0).of_kind, scene::Kind::sa1);
    EXPECT_EQ(Scene::from_text(scene.text()).patches, scene.patches);
    Scene unnamed = scene;
    unnamed.patches[0].of_kind.reset();
    EXPECT_EQ(unnamed.fingerprint(), scene.fingerprint());
    EXPECT_EQ(unnamed.part_fingerprints(), scene.part_fingerprints());
    const Scene renamed = Scene::from_text(std::string(skin_of_two) + "every_patch { of_kind: PC }");
    EXPECT_EQ(population_of(make_plan(renamed)).patches.at(1).kind, "PC");
    for (const auto kind : {scene::Kind::sa1, scene::Kind::ra, scene::Kind::pc})
        EXPECT_EQ(scene::preset(kind).of_kind, kind);
}

// The table in docs/afferents.md.
TEST(Kinds, HaveTheNumbersThatAreDocumented) {
    const auto numbers = [](scene::Kind kind) {
        const scene::Patch patch = scene::preset(kind);
        const scene::Neuron& neuron = patch.neuron;
        EXPECT_EQ(patch.afferents.value().jitter, 0.5);
        return std::vector<double>{patch.afferents.value().per_cm2,
                                   patch.afferents.value().field_sd_mm,
                                   neuron.tau_m_ms,
                                   neuron.tau_g_ms,
                                   neuron.delta_g,
                                   neuron.refractory_ms};
    };
    EXPECT_EQ(numbers(scene::Kind::sa1), (std::vector<double>{70, 0.5, 5, 440, 2.1, 1.8}));
    EXPECT_EQ(numbers(scene::Kind::ra), (std::vector<double>{140, 0.5, 34, 6, 9, 1.8}));
    EXPECT_EQ(numbers(scene::Kind::pc), (std::vector<double>{25, 3.27, 0.8, 3.5, 2.2, 2.2}));
    EXPECT_EQ(scene::preset(scene::Kind::sa1).encoder,
              scene::Encoder(scene::Sustained{.gain_mv_per_n = 12'000}));
    EXPECT_EQ(
        scene::preset(scene::Kind::ra).encoder,
        scene::Encoder(scene::Transient{.gain_mv_s_per_n = 360, .corner_hz = 46, .negative_ratio = 0.12}));
    EXPECT_EQ(
        scene::preset(scene::Kind::pc).encoder,
        scene::Encoder(scene::Vibration{.gain_mv_s2_per_n = 205, .corner_hz = 290, .negative_ratio = 0}));
    EXPECT_EQ(numbers(scene::Kind::sa1_dynamic), (std::vector<double>{70, 0.5, 60, 122, 2.6, 0.5}));
    EXPECT_EQ(scene::preset(scene::Kind::sa1_dynamic).encoder,
              scene::Encoder(scene::Sustained{.gain_mv_per_n = 4270,
                                              .dynamic = scene::Dynamic{.time_ms = 170, .corner_hz = 72}}));
}

}  // namespace
}  // namespace afferent
