// Which parts a scene has, and the force on each from its own spikes.
#include <gtest/gtest.h>

#include <cmath>

#include "afferent/engine/controller.hpp"
#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/part_plans.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

std::vector<PartPlan> parts_of(const std::string& text) {
    return make_plan(Scene::from_text(text), Commands::wanted).controller.value().parts;
}

std::vector<std::string> names(const std::vector<PartPlan>& parts) {
    std::vector<std::string> all;
    for (const PartPlan& part : parts) all.push_back(part.name);
    return all;
}

const std::string three_patches =
    "patch { name: 'thumb' elements: 2 share: [0.3, 0.2] } patch { name: 'index finger' elements: 1 share: "
    "0.5 } "
    "patch { name: 'thumb, quick' elements_of: 'thumb' encoder { transient {} } } decoder { parts: ";

TEST(PartPlans, AreLeftOutUnlessTheSceneAsks) {
    EXPECT_TRUE(parts_of("").empty());
    EXPECT_EQ(names(parts_of(three_patches + "PATCHES }")),
              (std::vector<std::string>{"thumb", "index_finger"}));
    EXPECT_EQ(names(parts_of(three_patches + "ELEMENTS }")),
              (std::vector<std::string>{"thumb_0", "thumb_1", "index_finger_0"}));
    EXPECT_EQ(names(parts_of(three_patches + "ELEMENTS patch: 'index finger' }")),
              (std::vector<std::string>{"index_finger_0"}))
        << "nobody reads the thumb";
}

TEST(PartPlans, LeaveTheForceThatComesToTheGrip) {
    const ControllerPlan plan =
        make_plan(Scene::from_text("decoder { filter {} parts: PATCHES } gain { lead_ms: 50 }"),
                  Commands::wanted)
            .controller.value();
    PartDecoders parts = make_part_decoders(plan);
    GripDecoder grip(plan.decoder, plan.afferents);
    parts.observe(scene_start, scene_start + 10ms, {});
    grip.observe(scene_start, scene_start + 10ms, {});
    EXPECT_TRUE(grip.estimate(scene_start + 10ms).coming);
    EXPECT_FALSE(parts.estimate(0, scene_start + 10ms).coming);
}

TEST(PartPlans, GiveColumnsDifferentNames) {
    EXPECT_EQ(names(parts_of("patch { name: 'a b' } patch { name: 'a,b' } decoder { parts: PATCHES }")),
              (std::vector<std::string>{"a_b", "a_b_"}));
}

TEST(PartPlans, DriveAPartByItsOwnNewtons) {
    const Plan plan = make_plan(Scene::from_text(three_patches + "PATCHES }"), Commands::wanted);
    const double gain = plan.patches[0].gain();
    const PartPlan& thumb = plan.controller.value().parts.at(0);
    EXPECT_EQ(thumb.decoded.share, 0.5);
    ASSERT_EQ(thumb.decoded.afferents.afferents.size(), 2U);
    EXPECT_DOUBLE_EQ(thumb.decoded.afferents.groups.at(0).drive_mv_per_n, gain * 0.6);
    EXPECT_DOUBLE_EQ(thumb.decoded.afferents.groups.at(1).drive_mv_per_n, gain * 0.4);
    EXPECT_DOUBLE_EQ(thumb.decoded.afferents.largest_grip_n, 10 / 0.4);
    // What the converter rounds off, 10 N in 4,095 counts, as the whole force.
    EXPECT_NEAR(thumb.decoded.afferents.groups.at(0).noise_n, 10.0 / 4095 / std::sqrt(12.0) / 0.6, 1e-9);
    const std::vector<PartPlan> elements = parts_of(three_patches + "ELEMENTS }");
    ASSERT_EQ(elements.size(), 3U);
    for (const PartPlan& element : elements)
        EXPECT_DOUBLE_EQ(element.decoded.afferents.groups.at(0).drive_mv_per_n,
                         plan.patches[element.patch].gain());
}

TEST(PartPlans, SpreadAPartEvenlyWhereNoShareIsKnown) {
    const auto parts = parts_of(
        "patch { name: 'palm' elements: 2 share: [0, 0] neuron { tau_m_ms: 10 } encoder { sustained { "
        "gain_mv_per_n: 8 "
        "bias_mv: 14 } } } patch { name: 'thumb' } decoder { parts: PATCHES }");
    ASSERT_EQ(parts.size(), 2U);
    EXPECT_EQ(parts[0].decoded.share, 0);
    EXPECT_EQ(parts[0].decoded.afferents.groups.at(0).drive_mv_per_n, 4);
    EXPECT_EQ(parts[0].decoded.afferents.largest_grip_n, 20);
}

TEST(PartPlans, ReadThroughReceptiveFields) {
    const auto parts = parts_of(
        "patch { name: 'a' elements: 3 share: [0.5, 0.25, 0.25] encoder { sustained { gain_mv_per_n: 8 "
        "bias_mv: 14 } } "
        "field { weight { element: 0 } weight { element: 1 weight: 0.5 } } field { weight { element: 2 } } } "
        "decoder { parts: ELEMENTS }");
    ASSERT_EQ(parts.size(), 3U);
    // One newton on element 0 comes with half of one on element 1.
    EXPECT_DOUBLE_EQ(parts[0].decoded.afferents.groups.at(0).drive_mv_per_n, 8 * (1 + 0.5 * 0.5));
    EXPECT_DOUBLE_EQ(parts[1].decoded.afferents.groups.at(0).drive_mv_per_n, 8 * (2 + 0.5));
    EXPECT_EQ(parts[2].decoded.afferents.afferents.at(0).address, 1U);
}

// Forces that the shares do not tell: each part has its own.
TEST(PartPlans, EstimateTheForceOnEachPatch) {
    for (const char* decoder : {"sliding_window", "exponential", "interval", "inversion", "filter"}) {
        Scene scene = Scene::from_text(
            "patch { name: 'thumb' elements: 2 } patch { name: 'palm' elements: 2 share: [0, 0] encoder { "
            "sustained { "
            "gain_mv_per_n: 3 bias_mv: 15 } } } source { pushed {} } link { in_process {} } "
            "decoder { parts: PATCHES " +
            std::string(decoder) + " {} }");
        Coprocessor coprocessor(scene);
        Controller controller(scene);
        const double forces_n[] = {1.5, 1.5, 4, 4};
        double sum_n[2]{};
        int steps = 0;
        for (TimePoint now = scene_start; now < scene_start + 4s; now += 5ms) {
            coprocessor.push({now, 0, std::span(forces_n).first(2)});
            coprocessor.push({now, 2, std::span(forces_n).last(2)});
            controller.observe(now, now + 5ms, coprocessor.advance(now + 5ms - 1ns));
            controller.step(now + 5ms, {User::rest_counts, User::rest_counts});
            if (now < scene_start + 2s) continue;
            ++steps;
            for (std::size_t i = 0; i < 2; ++i)
                sum_n[i] += controller.last_step().parts.at(i).estimate.force_n;
        }
        const auto parts = controller.last_step().parts;
        ASSERT_EQ(parts.size(), 2U);
        // Adapted, the mean is that of the force, to within the bend of the curves.
        EXPECT_NEAR(sum_n[0] / steps, 3, 0.05 * 3) << decoder;
        EXPECT_NEAR(sum_n[1] / steps, 8, 0.05 * 8) << decoder;

        Controller other(scene);
        other.resume(controller.snapshot());
        for (TimePoint now = scene_start + 4s; now < scene_start + 4100ms; now += 5ms) {
            const auto events = coprocessor.advance(now + 5ms - 1ns);
            for (Controller* each : {&controller, &other}) {
                each->observe(now, now + 5ms, events);
                each->step(now + 5ms, {User::rest_counts, User::rest_counts});
            }
            for (std::size_t i = 0; i < 2; ++i)
                ASSERT_EQ(other.last_step().parts.at(i).estimate,
                          controller.last_step().parts.at(i).estimate);
        }
    }
}

}  // namespace
}  // namespace afferent
