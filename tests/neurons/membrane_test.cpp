#include "afferent/neurons/membrane.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

// A rheobase of 1 mV + 2^-60 mV, which rounds to 1 mV. Either potential may be the one that loses its digits.
TEST(Membrane, KeepsWhatTheRheobaseLosesToRounding) {
    constexpr double lost_mv = 0x1p-60;
    LifParameters parameters;
    parameters.v_th_mv = lost_mv;
    parameters.v_r_mv = -1;
    EXPECT_EQ(Membrane(parameters).excess_mv(1), -lost_mv);
    parameters.v_th_mv = 1;
    parameters.v_r_mv = -lost_mv;
    EXPECT_EQ(Membrane(parameters).excess_mv(1), -lost_mv);
    EXPECT_EQ(Membrane(parameters).with_threshold(3).excess_mv(3), -lost_mv);
}

}  // namespace
}  // namespace afferent
