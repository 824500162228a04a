#include "afferent/runtime/event_key.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace afferent {
namespace {

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

}  // namespace
}  // namespace afferent
