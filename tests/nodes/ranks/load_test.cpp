#include "afferent/nodes/ranks/load.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "afferent/nodes/run.hpp"
#include "tests/value_or_throw.hpp"

namespace afferent::ranks {
namespace {

Plan pressed_harder_and_harder() {
    return make_plan(Scene::from_text(R"(
        duration_s: 2
        every_patch { encoder { sustained { gain_mv_per_n: 100 bias_mv: 10 } } }
        patch { name: "a" elements: 400 }
        patch { name: "b" elements: 400 }
        patch { name: "c" elements: 400 }
        source { profile { point { time_s: 0 force_n: 0 } point { time_s: 0.2 force_n: 400 } } }
        record { force: false picture: false }
        link { unix_socket {} })"));
}

TEST(RankLoads, AreOfTheBeginningAsTheRunSamplesIt) {
    Plan plan = pressed_harder_and_harder();
    const Plan::ShardPlan first = plan.shards.at(0);
    const auto found = beginning_of(plan);
    ASSERT_TRUE(found) << found.error().text;
    const Beginning& beginning = found.value();
    ASSERT_EQ(plan.shards.size(), 3U);
    EXPECT_EQ(plan.shards.front().count, first.count);
    ASSERT_GT(beginning.ends.size(), 10U);
    EXPECT_LE(beginning.end(), scene_start + 500ms);
    // Every element of all three patches in the first window.
    EXPECT_GE(beginning.forces_n.size(), 1200U);
    std::size_t samples = 0;
    for (const Beginning::Sampled& scan : beginning.scans) {
        samples += scan.count;
        ASSERT_LT(scan.window, beginning.ends.size());
        EXPECT_LT(scan.time, beginning.ends[scan.window]);
        EXPECT_GE(scan.time, scan.window > 0 ? beginning.ends[scan.window - 1] : scene_start);
    }
    EXPECT_EQ(samples, beginning.forces_n.size());
}

// A third of the afferents of b is in its first shard.
TEST(RankLoads, ShareTheSamplingOfAPatchByItsAfferents) {
    Plan plan = make_plan(Scene::from_text(R"(
        patch { name: "a" elements: 2 } patch { name: "b" elements: 3 }
        source { profile { point { force_n: 1 } } } link { unix_socket {} })"));
    ASSERT_EQ(plan.shards.size(), 2U);
    Plan::ShardPlan rest = plan.shards.back();
    plan.shards.back().count = 1;
    rest.begin += 1;
    rest.count = 2;
    plan.shards.push_back(rest);
    Beginning beginning{};
    for (const std::size_t window : {0U, 1U}) {
        beginning.scans.push_back({scene_start, 0, 2, window});
        beginning.scans.push_back({scene_start, 2, 3, window});
    }
    beginning.forces_n.resize(10);
    beginning.sampling_s = 30;
    const std::vector<double> loads = with_sampling({1, 2, 4}, plan, beginning);
    ASSERT_EQ(loads.size(), 3U);
    EXPECT_DOUBLE_EQ(loads[0], 1 + 12);
    EXPECT_DOUBLE_EQ(loads[1], 2 + 6);
    EXPECT_DOUBLE_EQ(loads[2], 4 + 12);
}

TEST(RankLoads, ComeWithTheEventsOfTheRun) {
    Plan plan = pressed_harder_and_harder();
    std::vector<Event> events;
    const Beginning beginning = value_or_throw(beginning_of(plan));
    const auto run = value_or_throw(Run::open(plan, {.events = [&](std::span<const Event> some) {
                                                  events.insert(events.end(), some.begin(), some.end());
                                              }}));
    while (run->next() <= beginning.end()) ASSERT_TRUE(run->do_next());

    const auto shards = plan.shards;
    ShardLoads loads = measure(plan, shards, beginning);
    EXPECT_EQ(plan.shards.size(), shards.size());
    ASSERT_EQ(loads.seconds.size(), shards.size());
    for (const double seconds : loads.seconds) EXPECT_GT(seconds, 0);
    std::sort(loads.events.begin(), loads.events.end());
    EXPECT_GT(events.size(), 1000U);
    EXPECT_EQ(loads.events, events);

    for (const EventsOfRanks& of_ranks : {EventsOfRanks{loads.events}, {{}, loads.events, {}}}) {
        const auto rest_s = rest_of_run(plan, beginning, of_ranks);
        ASSERT_TRUE(rest_s) << rest_s.error().text;
        EXPECT_GT(rest_s.value(), 0);
    }
    EXPECT_EQ(plan.shards.size(), shards.size());
}

TEST(RankLoads, AreKnownBeforeTheRunWhereItsSamplesAre) {
    const auto known = [](const std::string& source) {
        return is_known_before(make_plan(Scene::from_text("source { " + source + " }")));
    };
    EXPECT_TRUE(known("profile { point { force_n: 1 } }"));
    EXPECT_TRUE(known("table { path: 'a.csv' }"));
    EXPECT_FALSE(known("standard_input {}"));
    EXPECT_FALSE(known("simulated_hand {}"));
}

}  // namespace
}  // namespace afferent::ranks
