#include "afferent/runtime/indexed_queue.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace afferent {
namespace {

TimePoint at(std::int64_t ns) { return scene_start + Duration(ns); }

TEST(IndexedQueue, BreaksTiesByIndex) {
    IndexedQueue queue(3);
    queue.schedule(2, at(5));
    queue.schedule(0, at(5));
    queue.schedule(1, at(5));
    for (const IndexedQueue::Index expected : {0U, 1U, 2U}) {
        EXPECT_EQ(queue.next().index, expected);
        queue.remove(expected);
    }
    EXPECT_TRUE(queue.empty());
}

TEST(IndexedQueue, MovesAnEntryInsteadOfDuplicatingIt) {
    IndexedQueue queue(2);
    queue.schedule(0, at(1));
    queue.schedule(0, at(9));
    queue.schedule(1, at(5));
    EXPECT_EQ(queue.size(), 2U);
    EXPECT_EQ(queue.next(), (IndexedQueue::Entry{at(5), 1}));
}

TEST(IndexedQueue, RemovesWhatIsAbsentWithoutHarm) {
    IndexedQueue queue(2);
    queue.remove(1);
    EXPECT_TRUE(queue.empty());
    EXPECT_FALSE(queue.contains(1));
}

// Against an ordered map, over random schedules, moves, removals and pops.
TEST(IndexedQueue, AgreesWithAnOrderedMap) {
    constexpr IndexedQueue::Index size = 50;
    IndexedQueue queue(size);
    std::map<IndexedQueue::Index, TimePoint> times;
    std::mt19937 random(1);
    for (int step = 0; step < 20'000; ++step) {
        const auto index = static_cast<IndexedQueue::Index>(random() % size);
        if (random() % 4 != 0) {
            const TimePoint time = at(static_cast<std::int64_t>(random() % 100));
            queue.schedule(index, time);
            times[index] = time;
        } else {
            queue.remove(index);
            times.erase(index);
        }
        ASSERT_EQ(queue.size(), times.size());
        if (times.empty()) continue;
        auto least = times.begin();
        for (auto it = times.begin(); it != times.end(); ++it)
            if (it->second < least->second) least = it;
        ASSERT_EQ(queue.next(), (IndexedQueue::Entry{least->second, least->first}));
    }
}

}  // namespace
}  // namespace afferent
