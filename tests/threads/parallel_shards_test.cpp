// Shards that several threads compute. Run with ThreadSanitizer.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
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
    // The first half of each patch fires at the same instants, the others at many.
    std::vector<double> forces_n(plan.elements, 0.01);
    for (std::size_t i = 750; i < 1500; ++i) forces_n[i] += 1e-5 * static_cast<double>(i);
    for (int scan = 0; scan < 40; ++scan) {
        const TimePoint begin = scene_start + scan * 5ms;
        for (const PatchPlan& patch : plan.patches)
            coprocessor.push({begin, patch.first_element, std::span(forces_n).first(patch.elements())});
        // One window, or several, of which one is a nanosecond long and one empty.
        for (const Duration until :
             {Duration(1), Duration(2), Duration(2), Duration(2ms), Duration(5ms - 1ns)}) {
            if (scan % 2 == 0 && until < 2ms) continue;
            const auto events = coprocessor.advance(begin + until);
            all.insert(all.end(), events.begin(), events.end());
        }
    }
    return all;
}

TEST(ParallelShards, FireAlikeOnAnyNumberOfThreads) {
    const std::vector<Event> alone = events_of(1);
    EXPECT_GT(alone.size(), 10'000U);
    EXPECT_TRUE(std::is_sorted(alone.begin(), alone.end()));
    for (const std::uint32_t threads : {2U, 4U}) EXPECT_EQ(events_of(threads), alone) << threads;
}

// A scan that is large enough for its samples to be taken in by all threads.
TEST(ParallelShards, TakeTheSamplesOfALargeScanThatAreNumbers) {
    constexpr std::uint32_t elements = 70'001;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::vector<double> first_n(elements), second_n(elements);
    for (std::uint32_t i = 0; i < elements; ++i) {
        first_n[i] = 2e-4 + 1e-8 * (i % 1000);
        second_n[i] = 3e-4;
    }
    std::vector<double> with_gaps_n = second_n;
    for (const auto& [element, force_n] :
         {std::pair{0U, nan}, {1U, infinity}, {35'000U, -infinity}, {70'000U, nan}})
        with_gaps_n[element] = force_n;
    const auto events = [&](std::uint32_t threads, bool one_by_one) {
        Scene scene;
        scene.patches = {{.name = "skin", .elements = elements}};
        scene.source = scene::SimulatedHand();
        scene.duration_s = 0.5;
        scene.runtime.threads = threads;
        Coprocessor coprocessor(make_plan(scene));
        coprocessor.push({scene_start, 0, first_n});
        std::vector<Event> all;
        const auto advance = [&](TimePoint until) {
            const auto more = coprocessor.advance(until);
            all.insert(all.end(), more.begin(), more.end());
        };
        advance(scene_start + 5ms - 1ns);
        // Two scans wait, of which the first call takes one.
        const TimePoint second = scene_start + 5ms;
        if (one_by_one) {
            for (const auto& [begin, end] : {std::pair{2U, 35'000U}, {35'001U, 70'000U}})
                coprocessor.push({second, begin, std::span(second_n).subspan(begin, end - begin)});
        } else {
            coprocessor.push({second, 0, with_gaps_n});
            EXPECT_EQ(coprocessor.refused_samples(), 4U);
        }
        coprocessor.push({second + 5ms, 0, first_n});
        EXPECT_EQ(coprocessor.waiting_samples(), 2 * elements - 4);
        advance(second + 5ms - 1ns);
        EXPECT_EQ(coprocessor.waiting_samples(), elements);
        advance(second + 50ms);
        EXPECT_EQ(coprocessor.waiting_samples(), 0U);
        return all;
    };
    const std::vector<Event> expected = events(1, true);
    EXPECT_GT(expected.size(), elements);
    for (const std::uint32_t threads : {1U, 2U, 3U}) EXPECT_EQ(events(threads, false), expected) << threads;
}

}  // namespace
}  // namespace afferent
