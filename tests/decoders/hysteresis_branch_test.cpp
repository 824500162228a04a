#include "afferent/decoders/hysteresis_branch.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

constexpr double sigma_n = 0.05;

// Loaded to 10 N of sensed force.
HysteresisBranch loaded() {
    HysteresisBranch branch(0.1);
    for (double sensed_n = 1; sensed_n <= 10; ++sensed_n) branch.follow(sensed_n, sigma_n);
    return branch;
}

TEST(HysteresisBranch, ReadsLowWhileLoading) {
    EXPECT_EQ(loaded().direction(10, sigma_n), 1);
    EXPECT_DOUBLE_EQ(loaded().grip_n(9.6, sigma_n) * (1 - 0.1), 9.6)
        << "within the play it is still on that branch";
}

TEST(HysteresisBranch, ReadsHighAfterFiveMeasurementsBeyondHalfThePlay) {
    HysteresisBranch branch = loaded();
    for (int i = 0; i < 4; ++i) branch.follow(8, sigma_n);
    branch.follow(10, sigma_n);
    for (int i = 0; i < 4; ++i) branch.follow(8, sigma_n);
    EXPECT_EQ(branch.direction(10, sigma_n), 1) << "four in a row may be wrong";
    branch.follow(8, sigma_n);
    EXPECT_EQ(branch.direction(8, sigma_n), -1);
    EXPECT_DOUBLE_EQ(branch.grip_n(8, sigma_n) * (1 + 0.1), 8);
    for (int i = 0; i < 5; ++i) branch.follow(9.5, sigma_n);
    EXPECT_EQ(branch.direction(9.5, sigma_n), 1);
}

// Two standard deviations below what was measured, and half of the play: 10 - 1 - 0.45.
TEST(HysteresisBranch, TurnsAtAForceThatWasSurelyReached) {
    HysteresisBranch branch(0.1);
    branch.follow(10, 0.5);
    EXPECT_EQ(branch.direction(8.6, 0), 1);
    EXPECT_EQ(branch.direction(8.5, 0), -1);
}

TEST(HysteresisBranch, SilenceTurnsItForTheTimeBeing) {
    HysteresisBranch branch = loaded();
    EXPECT_EQ(branch.direction(8, sigma_n), -1);
    EXPECT_EQ(branch.direction(10, sigma_n), 1) << "but no measurement has said so";
}

}  // namespace
}  // namespace afferent
