#include "afferent/nodes/force_error.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

TEST(ForceError, IsTheRootMeanSquareAndTheLargest) {
    ForceError error;
    EXPECT_EQ(error.rms_n(), std::nullopt);
    EXPECT_EQ(error.max_n(), std::nullopt);
    error.add(3, 4);
    EXPECT_EQ(error.rms_n(), 1);
    EXPECT_EQ(error.max_n(), 1);
    // The squares are 1 and 49.
    error.add(9, 2);
    EXPECT_EQ(error.rms_n(), 5);
    EXPECT_EQ(error.max_n(), 7);
    error.add(2, 2);
    EXPECT_DOUBLE_EQ(error.rms_n().value(), std::sqrt(50.0 / 3));
}

}  // namespace
}  // namespace afferent
