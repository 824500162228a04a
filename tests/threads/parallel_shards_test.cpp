// Shards that several threads compute. Run with ThreadSanitizer.
#include <gtest/gtest.h>

#include <vector>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

// Swept and predicted patches, pressed so hard that every window has events of each.
Scene skin(std::uint32_t threads) {
    Scene scene;
    scene.patches.clear();
    for (const char* const name : {"thumb", "index", "middle", "palm"}) {
        scene.patches.push_back({.name = name, .elements = 1500});
        scene.patches.back().neuron.form =
            scene.patches.size() % 2 == 0 ? scene::Form::dense : scene::Form::sparse;
    }
    scene.source = scene::SimulatedHand();
    scene.duration_s = 0.5;
    scene.runtime.threads = threads;
    return scene;
}

std::vector<Event> events_of(std::uint32_t threads) {
    const Plan plan = make_plan(skin(threads));
    Coprocessor coprocessor(plan);
    EXPECT_EQ(coprocessor.threads(), threads);
    std::vector<Event> all;
    const std::vector<double> forces_n(plan.elements, 0.01);
    for (int window = 0; window < 40; ++window) {
        const TimePoint begin = scene_start + window * 5ms;
        for (const PatchPlan& patch : plan.patches)
            coprocessor.push({begin, patch.first_element, std::span(forces_n).first(patch.elements())});
        const auto events = coprocessor.advance(begin + 5ms - 1ns);
        all.insert(all.end(), events.begin(), events.end());
    }
    return all;
}

TEST(ParallelShards, FireAlikeOnAnyNumberOfThreads) {
    const std::vector<Event> alone = events_of(1);
    EXPECT_GT(alone.size(), 10'000U);
    for (const std::uint32_t threads : {2U, 4U}) EXPECT_EQ(events_of(threads), alone) << threads;
}

}  // namespace
}  // namespace afferent
