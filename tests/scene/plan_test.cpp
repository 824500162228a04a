#include "afferent/scene/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace afferent {
namespace {

bool built(const Plan& plan, const std::string& name) {
    const auto part = std::find_if(plan.items.begin(), plan.items.end(),
                                   [&](const PlanItem& p) { return p.name.find(name) != std::string::npos; });
    EXPECT_NE(part, plan.items.end()) << name;
    return part != plan.items.end() && part->built;
}

TEST(Plan, LeavesOutWhatASceneDoesNotNeed) {
    const Plan lean = make_plan(Scene::from_text(R"(
        patch { name: "a" neuron { delta_g: 0 } } record { force: false picture: false events: false }
        source { profile { point { force_n: 1 } } } link { in_process {} })"));
    for (const char* part : {"adaptation", "refractory", "noise", "packets", "decoder", "motor",
                             "recording of events", "picture", "worker threads"})
        EXPECT_FALSE(built(lean, part)) << part;
    EXPECT_TRUE(lean.in_process());

    const Plan full = make_plan(Scene::from_text(R"(
        patch { name: "a" elements: 20000 neuron { delta_g: 0.1 refractory_ms: 1 } sensor { noise_counts: 1 } }
        runtime { threads: 2 } link { tcp {} })"));
    for (const char* part : {"adaptation", "refractory", "noise", "packets", "decoder", "motor", "recording",
                             "picture", "worker threads"})
        EXPECT_TRUE(built(full, part)) << part;
    EXPECT_FALSE(full.in_process());
    EXPECT_EQ(full.threads, 2U);
}

TEST(Plan, TellsWhatTheLinkIs) {
    const auto plan = [](const std::string& link) {
        return make_plan(Scene::from_text("patch { name: 'a' } link { " + link + " }"));
    };
    const Plan plain = plan("udp {} channel { loss: 0.1 }");
    EXPECT_FALSE(built(plain, "keys"));
    for (const char* part : {"channel", "stale", "silence"}) EXPECT_TRUE(built(plain, part)) << part;
    const auto reason = [](const Plan& told, const std::string& name) {
        for (const PlanItem& part : told.items)
            if (part.name.find(name) != std::string::npos) return part.reason;
        return std::string();
    };
    EXPECT_NE(reason(plain, "packets").find("UDP 127.0.0.1:7450"), std::string::npos);
    EXPECT_NE(reason(plan("tcp {} keys: 'k'"), "keys").find("TLS"), std::string::npos);
    EXPECT_NE(reason(plan("serial { device: 't' } keys: 'k'"), "keys").find("ChaCha20"), std::string::npos);
    // Seals are on the line as well.
    EXPECT_GT(plan("udp {} keys: 'k'").resting_bytes_per_second, 2 * plain.resting_bytes_per_second);
}

// Each afferent is a group of its own; comparing each with all others would take half a minute.
TEST(Plan, DecodesAHundredThousandElementsThatDiffer) {
    constexpr std::uint32_t elements = 100'000;
    Scene scene;
    scene.patches = {{.name = "skin", .elements = elements}};
    for (std::uint32_t i = 0; i < elements; ++i)
        scene.patches[0].share.push_back((1 + 0.5 * i / elements) * 0.7 / elements);
    scene.decoder.kind = scene::Filter();
    const Plan plan = make_plan(scene, Commands::wanted);
    EXPECT_EQ(plan.controller.value().afferents.groups.size(), elements);
    EXPECT_EQ(plan.controller.value().afferents.afferents.size(), elements);
}

TEST(Plan, TellsWhichBoundTheGainGoesBy) {
    const auto gain = [](const std::string& text) {
        const Plan plan = make_plan(Scene::from_text("gain { " + text + " }"), Commands::wanted);
        const auto part = std::ranges::find(plan.items, "gain by an upper bound", &PlanItem::name);
        return part == plan.items.end() ? "" : (part->built ? "built: " : "left out: ") + part->reason;
    };
    EXPECT_EQ(gain("upper_bound_sigmas: 0.5"), "built: gain.upper_bound_sigmas: of the force and 0.5 sigma");
    EXPECT_EQ(gain("upper_bound_sigmas: 0 doubtful: AS_ESTIMATED"),
              "left out: gain.doubtful is AS_ESTIMATED: the gain is that of the estimate");
    EXPECT_EQ(
        gain("upper_bound_sigmas: 0"),
        "left out: gain.upper_bound_sigmas is 0: only that of a doubtful estimate is by its upper bound");
}

TEST(Plan, HasNoGainWhereNobodyReadsTheEstimate) {
    const Plan plan =
        make_plan(Scene::from_text("source { pushed {} } record { force: false picture: false } "
                                   "gain { upper_bound_sigmas: 0.5 }"));
    ASSERT_FALSE(plan.controller);
    const auto item = std::ranges::find(plan.items, "gain by an upper bound", &PlanItem::name);
    ASSERT_NE(item, plan.items.end());
    EXPECT_FALSE(item->built);
    EXPECT_EQ(item->reason, "nobody reads the estimate");
}

TEST(Plan, TellsTheDecoderHowWellItsSensorsAreKnown) {
    const Plan plan = make_plan(Scene::from_text(
        "decoder { filter {} parts: PATCHES } uncertainty { gain: 0.08 share: 0.25 share_time_s: 3 }"));
    const Uncertainty told{.gain = 0.08, .share = 0.25, .share_time_s = 3};
    EXPECT_EQ(plan.controller.value().afferents.uncertainty, told);
    ASSERT_EQ(plan.controller.value().parts.size(), 3U);
    for (const PartPlan& part : plan.controller.value().parts)
        EXPECT_EQ(part.decoded.afferents.uncertainty, told);
    const auto part = std::ranges::find(plan.items, "uncertainty of the sensors", &PlanItem::name);
    ASSERT_NE(part, plan.items.end());
    EXPECT_TRUE(part->built);
    EXPECT_EQ(part->reason,
              "uncertainty: gains within 8 % each and 1 % in common, shares within 25 % over 3 s, zeros "
              "within 0 N, "
              "hysteresis within 1 %, adaptation within 0 %");
    EXPECT_FALSE(built(make_plan(Scene()), "uncertainty of the sensors")) << "a window has no use for it";
}

TEST(Plan, StartsNoThreadForNineElements) {
    const Plan plan = make_plan(Scene::from_file(AFFERENT_SOURCE_DIR "/examples/grasp.txtpb"));
    EXPECT_EQ(plan.threads, 1U);
    EXPECT_FALSE(built(plan, "worker threads"));
}

TEST(Plan, CostsLessWithoutAdaptation) {
    const double with = make_plan(Scene::from_text("patch { name: 'a' elements: 1000 }")).bytes_per_neuron;
    const double without =
        make_plan(Scene::from_text("patch { name: 'a' elements: 1000 neuron { delta_g: 0 } }"))
            .bytes_per_neuron;
    EXPECT_LT(without, with);
}

}  // namespace
}  // namespace afferent
