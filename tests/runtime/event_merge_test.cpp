#include "afferent/runtime/event_merge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace afferent {
namespace {

using Streams = std::vector<std::vector<Event>>;

std::vector<Event> merged(const Streams& streams) {
    EventMerge merge(streams.size());
    std::vector<Event> result{{scene_start, 99}};  // is replaced
    merge([&](std::size_t i) { return std::span(streams[i]); }, result);
    return result;
}

Event event(int ns, Address address) { return {scene_start + Duration(ns), address}; }

TEST(EventMerge, GivesNothingForNothing) {
    EXPECT_TRUE(merged({}).empty());
    EXPECT_TRUE(merged({{}, {}}).empty());
}

TEST(EventMerge, CopiesASingleStream) {
    const std::vector<Event> events{event(1, 3), event(1, 4), event(7, 0)};
    EXPECT_EQ(merged({events}), events);
    EXPECT_EQ(merged({{}, events, {}}), events);
}

TEST(EventMerge, OrdersByTimeThenAddress) {
    EXPECT_EQ(merged({{event(1, 5), event(3, 5)}, {event(1, 2), event(2, 9)}, {event(3, 4)}}),
              (std::vector{event(1, 2), event(1, 5), event(2, 9), event(3, 4), event(3, 5)}));
}

TEST(EventMerge, KeepsEqualEventsOfEveryStream) {
    const Streams streams(5, {event(1, 1), event(1, 1), event(2, 1)});
    const auto result = merged(streams);
    EXPECT_EQ(result.size(), 15U);
    EXPECT_TRUE(std::is_sorted(result.begin(), result.end()));
}

TEST(EventMerge, IsASortOfAllEvents) {
    std::mt19937_64 random(1);
    for (const std::size_t count : {2, 3, 16, 17, 255, 1000}) {
        Streams streams(count);
        std::vector<Event> all;
        for (auto& stream : streams) {
            stream.resize(random() % 20);
            for (Event& each : stream)
                each = event(static_cast<int>(random() % 50), static_cast<Address>(random() % 8));
            std::sort(stream.begin(), stream.end());
            all.insert(all.end(), stream.begin(), stream.end());
        }
        std::sort(all.begin(), all.end());
        EXPECT_EQ(merged(streams), all) << count;
    }
}

TEST(EventMerge, AllocatesNothingForARoundLikeTheLast) {
    const Streams streams(100, {event(1, 1), event(2, 2)});
    EventMerge merge(streams.size());
    std::vector<Event> result;
    const auto stream = [&](std::size_t i) { return std::span(streams[i]); };
    merge(stream, result);
    const Event* const data = result.data();
    merge(stream, result);
    EXPECT_EQ(result.data(), data);
}

}  // namespace
}  // namespace afferent
