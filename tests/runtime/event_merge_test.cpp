#include "afferent/runtime/event_merge.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace afferent {
namespace {

using Streams = std::vector<std::vector<EventKey>>;

std::vector<EventKey> merged(const Streams& streams) {
    EventMerge merge(streams.size());
    std::vector<EventKey> result;
    merge([&](std::size_t i) { return std::span(streams[i]); }, [&](EventKey key) { result.push_back(key); });
    return result;
}

EventKey event(int ns, Address address) {
    EventKeys keys;
    keys.add(scene_start + Duration(ns), address);
    return keys.keys().front();
}

TEST(EventKeys, SortAsTheirEventsDo) {
    EventKeys keys;
    keys.begin(scene_start + 1h);
    const std::vector<Event> events{{scene_start + 1h, 3},
                                    {scene_start + 1h, (1U << EventKeys::address_bits) - 1},
                                    {scene_start + 1h + 1ns, 0},
                                    {scene_start + 1h + EventKeys::longest - 1ns, 7}};
    for (const Event& each : events) keys.add(each.time, each.address);
    EXPECT_TRUE(std::is_sorted(keys.keys().begin(), keys.keys().end()));
    for (std::size_t i = 0; i < events.size(); ++i)
        EXPECT_EQ(EventKeys::event(keys.base(), keys.keys()[i]), events[i]);
}

TEST(EventMerge, GivesNothingForNothing) {
    EXPECT_TRUE(merged({}).empty());
    EXPECT_TRUE(merged({{}, {}}).empty());
}

TEST(EventMerge, CopiesASingleStream) {
    const std::vector<EventKey> events{event(1, 3), event(1, 4), event(7, 0)};
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
        std::vector<EventKey> all;
        for (auto& stream : streams) {
            stream.resize(random() % 20);
            for (EventKey& each : stream)
                each = event(static_cast<int>(random() % 50), static_cast<Address>(random() % 8));
            std::sort(stream.begin(), stream.end());
            all.insert(all.end(), stream.begin(), stream.end());
        }
        std::sort(all.begin(), all.end());
        EXPECT_EQ(merged(streams), all) << count;
    }
}

}  // namespace
}  // namespace afferent
