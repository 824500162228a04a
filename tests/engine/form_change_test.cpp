// Shards that change their form as more or less happens in them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/engine/coprocessor.hpp"
#include "afferent/engine/scan_routes.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t skin_elements = 3000;
constexpr int form_windows = 300;

// Clocked, so that both forms are allowed.
Scene clocked_skin(scene::Form form, std::uint32_t threads = 1) {
    Scene scene;
    scene.patches = {{.name = "skin", .elements = skin_elements}};
    scene.patches[0].encoder = scene::Sustained{.gain_mv_per_n = 40};
    scene.patches[0].neuron.form = form;
    scene.patches[0].neuron.refractory_ms = 2;
    scene.patches[0].spread.phase = scene::Uniform{.lowest = 0};
    scene.source = scene::Profile{{{.time_s = 0, .force_n = 0}}};
    scene.record = {.events = true, .force = false, .picture = false};
    scene.runtime.threads = threads;
    return scene;
}

struct PressedHalf {
    std::vector<Event> events;
    std::size_t most_dense = 0;
    std::size_t dense_at_end = 0;
    std::uint64_t changes = 0;
};

// For a second the first half of the skin is pressed, a little differently at each scan; then nothing is, but
// for a single element.
PressedHalf press_half(const Scene& scene, int windows_at_once = 1) {
    Coprocessor coprocessor(scene);
    PressedHalf response;
    std::vector<double> forces_n(skin_elements / 2);
    const std::vector<double> nothing_n(skin_elements / 2, 0.0);
    for (int window = 0; window < form_windows; ++window) {
        const TimePoint time = scene_start + window * 5ms;
        for (std::size_t i = 0; i < forces_n.size(); ++i)
            forces_n[i] = 1 + 0.5 * std::sin(0.1 * window + 0.7 * static_cast<double>(i));
        if (window < 200) coprocessor.push({time, 0, forces_n});
        if (window == 200) coprocessor.push({time, 0, nothing_n});
        if (window > 200) coprocessor.push({time, 7, std::span(forces_n).first(1)});
        if ((window + 1) % windows_at_once != 0) continue;
        const auto events = coprocessor.advance(time + 5ms - 1ns);
        response.events.insert(response.events.end(), events.begin(), events.end());
        response.most_dense = std::max(response.most_dense, coprocessor.dense_shards());
    }
    response.dense_at_end = coprocessor.dense_shards();
    response.changes = coprocessor.form_changes();
    return response;
}

void expect_within_a_nanosecond(std::vector<Event> some, std::vector<Event> others) {
    const auto by_address = [](const Event& a, const Event& b) {
        return std::pair(a.address, a.time) < std::pair(b.address, b.time);
    };
    std::sort(some.begin(), some.end(), by_address);
    std::sort(others.begin(), others.end(), by_address);
    ASSERT_EQ(some.size(), others.size());
    for (std::size_t i = 0; i < some.size(); ++i) {
        ASSERT_EQ(some[i].address, others[i].address);
        ASSERT_LE(std::chrono::abs(some[i].time - others[i].time), 1ns);
    }
}

TEST(FormChange, SweepsWhatIsBusyAndPredictsTheRest) {
    const PressedHalf response = press_half(clocked_skin(scene::Form::automatic));
    EXPECT_EQ(response.most_dense, 2U) << "shards of 1024: the first, and half of the second";
    EXPECT_EQ(response.dense_at_end, 0U);
    EXPECT_EQ(response.changes, 4U) << "there and back, once each";
}

TEST(FormChange, GivesTheEventsOfEitherForm) {
    const PressedHalf response = press_half(clocked_skin(scene::Form::automatic));
    EXPECT_GT(response.events.size(), 10'000U);
    const PressedHalf sparse = press_half(clocked_skin(scene::Form::sparse));
    const PressedHalf dense = press_half(clocked_skin(scene::Form::dense));
    EXPECT_EQ(sparse.most_dense, 0U);
    EXPECT_EQ(dense.dense_at_end, 3U);
    expect_within_a_nanosecond(response.events, sparse.events);
    expect_within_a_nanosecond(response.events, dense.events);
}

TEST(FormChange, DependsOnNeitherThreadsNorWindows) {
    const PressedHalf response = press_half(clocked_skin(scene::Form::automatic));
    const PressedHalf on_threads = press_half(clocked_skin(scene::Form::automatic, 3));
    EXPECT_GT(response.events.size(), 10'000U);
    EXPECT_EQ(on_threads.events, response.events);
    EXPECT_EQ(on_threads.changes, response.changes);
    EXPECT_EQ(press_half(clocked_skin(scene::Form::automatic), 4).events, response.events);
}

TEST(FormChange, IsForgottenByAReset) {
    const Scene scene = clocked_skin(scene::Form::automatic);
    Coprocessor coprocessor(scene);
    const std::vector<double> forces_n(skin_elements, 1.0);
    const auto run = [&] {
        std::vector<Event> all;
        for (int window = 0; window < 20; ++window) {
            const TimePoint time = scene_start + window * 5ms;
            std::vector<double> now_n = forces_n;
            for (double& force_n : now_n) force_n += 0.01 * window;
            coprocessor.push({time, 0, now_n});
            const auto events = coprocessor.advance(time + 5ms - 1ns);
            all.insert(all.end(), events.begin(), events.end());
        }
        EXPECT_EQ(coprocessor.dense_shards(), 3U);
        return all;
    };
    const auto first = run();
    EXPECT_FALSE(first.empty());
    coprocessor.reset();
    EXPECT_EQ(coprocessor.dense_shards(), 0U);
    EXPECT_EQ(run(), first);
}

TEST(ScanRoutes, FindEachReaderOfAScan) {
    Scene scene = clocked_skin(scene::Form::automatic);
    scene.patches.push_back({.name = "same", .elements_of = "skin"});
    scene.patches.back().encoder = scene::Sustained{.gain_mv_per_n = 40};
    const Plan plan = make_plan(scene);
    ASSERT_EQ(plan.shards.size(), 6U);
    ScanRoutes routes(plan);
    const std::vector<double> forces_n(skin_elements, 1.0);
    const auto readers = [&](Address first, std::size_t count) {
        std::vector<std::uint32_t> found;
        routes.for_each_reader({scene_start, first, std::span(forces_n).first(count)},
                               [&](std::uint32_t shard) { found.push_back(shard); });
        std::sort(found.begin(), found.end());
        return found;
    };
    EXPECT_EQ(readers(0, 1), (std::vector<std::uint32_t>{0, 3}));
    EXPECT_EQ(readers(1023, 2), (std::vector<std::uint32_t>{0, 1, 3, 4}));
    EXPECT_EQ(readers(2999, 1), (std::vector<std::uint32_t>{2, 5}));
    EXPECT_EQ(readers(0, skin_elements), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
}

}  // namespace
}  // namespace afferent
