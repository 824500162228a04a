// Afferents that read several elements.
#include <gtest/gtest.h>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

Scene with_fields(std::vector<scene::Field> fields,
                  scene::Encoder encoder = scene::Sustained{.gain_mv_per_n = 20}) {
    Scene scene;
    scene.patches = {{.name = "skin", .elements = 4, .field = std::move(fields), .encoder = encoder}};
    scene.source = scene::Pushed();
    // Transient afferents alone tell no force.
    scene.record = {.events = true, .force = false, .picture = false};
    return scene;
}

std::vector<Event> events_of(const Scene& scene, const std::vector<Scan>& scans) {
    Coprocessor coprocessor(scene);
    for (const Scan& scan : scans) coprocessor.push(scan);
    const auto events = coprocessor.advance(scene_start + 1s);
    return {events.begin(), events.end()};
}

const std::vector<double> first_n{2, 0.5, 1, 0};
const std::vector<double> second_n{0.25, 3, 0, 1.5};
const std::vector<Scan> touch{{scene_start + 10ms, 0, first_n}, {scene_start + 300ms, 0, second_n}};

TEST(ReceptiveFields, OfOneElementEachAreTheElementsThemselves) {
    std::vector<scene::Field> each;
    for (std::uint32_t element = 0; element < 4; ++element) each.push_back({{{.element = element}}});
    for (const scene::Encoder& encoder : {scene::Encoder(scene::Sustained{.gain_mv_per_n = 20}),
                                          scene::Encoder(scene::Transient{.gain_mv_s_per_n = 8})}) {
        const auto expected = events_of(with_fields({}, encoder), touch);
        EXPECT_GT(expected.size(), 20U);
        EXPECT_EQ(events_of(with_fields(each, encoder), touch), expected);
    }
}

TEST(ReceptiveFields, AddUpWhatTheirElementsFeel) {
    const Scene scene = with_fields(
        {{{{.element = 0, .weight = 0.5}, {.element = 3, .weight = 2}}}, {{{.element = 1}, {.element = 2}}}});
    EXPECT_EQ(make_plan(scene).addresses, 2U);
    // The same sums on elements of their own.
    Scene sums = with_fields({});
    sums.patches[0].elements = 2;
    const std::vector<double> first_sums_n{1, 1.5};
    const std::vector<double> second_sums_n{3.125, 3};
    const auto expected =
        events_of(sums, {{touch[0].time, 0, first_sums_n}, {touch[1].time, 0, second_sums_n}});
    EXPECT_GT(expected.size(), 20U);
    EXPECT_EQ(events_of(scene, touch), expected);
}

// A scan may bring an element at a time, and leave others as they were.
TEST(ReceptiveFields, HoldTheForcesOfElementsThatAreNotSampled) {
    const Scene scene = with_fields({{{{.element = 0}, {.element = 2}}}});
    const std::vector<double> one_n{1};
    const std::vector<double> two_n{2};
    const auto apart = events_of(scene, {{scene_start + 10ms, 0, one_n}, {scene_start + 10ms, 2, two_n}});
    const std::vector<double> both_n{1, 0, 2, 0};
    EXPECT_GT(apart.size(), 10U);
    EXPECT_EQ(apart, events_of(scene, {{scene_start + 10ms, 0, both_n}}));
    const auto unread = events_of(scene, {{scene_start + 10ms, 0, both_n}, {scene_start + 200ms, 1, two_n}});
    EXPECT_EQ(unread, apart) << "nobody reads that element";
}

// The decoder knows the share of the grip force that an afferent reads.
TEST(ReceptiveFields, HaveTheSharesOfTheGripThatTheirElementsHave) {
    Scene scene = with_fields({{{{.element = 0, .weight = 0.5}, {.element = 3, .weight = 2}}}});
    scene.patches[0].share = {0.4, 0.3, 0.2, 0.1};
    scene.record = {};
    const Plan plan = make_plan(scene);
    EXPECT_DOUBLE_EQ(plan.patches[0].share_of(0), 0.5 * 0.4 + 2 * 0.1);
    ASSERT_TRUE(plan.controller);
    ASSERT_EQ(plan.controller->afferents.afferents.size(), 1U);
    EXPECT_DOUBLE_EQ(plan.controller->afferents.afferents[0].share, 0.5 * 0.4 + 2 * 0.1);
}

}  // namespace
}  // namespace afferent
