#include "afferent/nodes/force_error.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

TEST(ForceError, IsTheRootMeanSquareAndTheLargest) {
    ForceError error;
    EXPECT_EQ(error.rms_n(), std::nullopt);
    EXPECT_EQ(error.max_n(), std::nullopt);
    error.add(3, 3.5);
    EXPECT_EQ(error.rms_n(), 0.5);
    EXPECT_EQ(error.max_n(), 0.5);
    // The squares are 0.25 and 12.25.
    error.add(9, 5.5);
    EXPECT_EQ(error.rms_n(), 2.5);
    EXPECT_EQ(error.max_n(), 3.5);
    error.add(2, 2);
    EXPECT_DOUBLE_EQ(error.rms_n().value(), std::sqrt(12.5 / 3));
}

}  // namespace
}  // namespace afferent
