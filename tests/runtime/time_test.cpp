#include "afferent/runtime/time.hpp"

#include <gtest/gtest.h>

#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {
namespace {

TEST(SampleTime, IsTheNearestNanosecondWithoutDrift) {
    EXPECT_EQ(sample_time(0, 1000), scene_start);
    EXPECT_EQ(sample_time(3, 1000), scene_start + 3ms);
    EXPECT_EQ(sample_time(2, 3), scene_start + 666'666'667ns);
    EXPECT_EQ(sample_time(3, 3), scene_start + 1s);
}

TEST(VirtualTime, IsTheScenesOwn) {
    EXPECT_EQ(virtual_time(MonotonicTime(5ms)), scene_start + 5ms);
    EXPECT_EQ(wall_time(scene_start + 5ms), MonotonicTime(5ms));
}

}  // namespace
}  // namespace afferent
