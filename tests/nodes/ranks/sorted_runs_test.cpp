#include "afferent/nodes/ranks/sorted_runs.hpp"

#include <gtest/gtest.h>

namespace afferent::ranks {
namespace {

using Events = std::vector<Event>;

Events of(std::span<const Event> events) { return {events.begin(), events.end()}; }

// Events at these milliseconds, of an address each.
Events run(Address address, std::initializer_list<int> times_ms) {
    Events events;
    for (const int time_ms : times_ms) events.push_back({scene_start + time_ms * 1ms, address});
    return events;
}

TEST(SortedRuns, AreMergedByTimeAndThenByAddress) {
    SortedRuns runs;
    EXPECT_TRUE(runs.merged().empty());
    runs.add(run(0, {2, 5}));
    EXPECT_EQ(of(runs.merged()), run(0, {2, 5}));
    runs.clear();
    runs.add(run(2, {3, 5}));
    runs.add(run(7, {}));
    runs.add(run(1, {1, 5, 9}));
    runs.add(run(0, {5}));
    EXPECT_EQ(of(runs.merged()), (Events{{scene_start + 1ms, 1},
                                         {scene_start + 3ms, 2},
                                         {scene_start + 5ms, 0},
                                         {scene_start + 5ms, 1},
                                         {scene_start + 5ms, 2},
                                         {scene_start + 9ms, 1}}));
    runs.clear();
    EXPECT_TRUE(runs.merged().empty());
}

// Run k of n has the times k, k + n and so on.
TEST(SortedRuns, AreMergedHoweverManyThereAre) {
    SortedRuns runs;
    for (int n = 1; n <= 9; ++n) {
        runs.clear();
        for (int k = 0; k < n; ++k) runs.add(run(3, {k, k + n, k + 2 * n}));
        Events expected;
        for (int i = 0; i < 3 * n; ++i) expected.push_back({scene_start + i * 1ms, 3});
        EXPECT_EQ(of(runs.merged()), expected) << n;
    }
}

}  // namespace
}  // namespace afferent::ranks
