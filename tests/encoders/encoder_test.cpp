#include <gtest/gtest.h>

#include "afferent/encoders/calibration.hpp"
#include "afferent/encoders/sustained.hpp"
#include "afferent/encoders/transient.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

TimePoint at(Duration t) { return scene_start + t; }

TEST(Sustained, IsLinearInForce) {
    const Sustained encoder({.gain_mv_per_n = 2, .bias_mv = 5});
    Sustained::State state;
    EXPECT_EQ(encoder.drive_mv(state, at(0s), 0), 5);
    EXPECT_EQ(encoder.drive_mv(state, at(5ms), 3), 11);
}

TEST(Transient, IsTheRectifiedSlopeBetweenUnevenSamples) {
    const Transient encoder({.gain_mv_s_per_n = 0.5, .bias_mv = 1});
    Transient::State state;
    EXPECT_EQ(encoder.drive_mv(state, at(0s), 4), 1) << "one sample has no slope";
    EXPECT_DOUBLE_EQ(encoder.drive_mv(state, at(10ms), 5), 1 + 0.5 * 100);
    EXPECT_DOUBLE_EQ(encoder.drive_mv(state, at(30ms), 1), 1 + 0.5 * 200) << "release drives as onset does";
    EXPECT_EQ(encoder.drive_mv(state, at(31ms), 1), 1) << "a held force does not drive";
}

TEST(Transient, LeavesReleaseOutWhereItRectifiesHalfAWave) {
    const Transient encoder(
        {.gain_mv_s_per_n = 0.5, .bias_mv = 1, .rectification = {.negative_ratio = 0, .threshold = 20}});
    Transient::State state;
    EXPECT_EQ(encoder.drive_mv(state, at(0s), 4), 1);
    EXPECT_DOUBLE_EQ(encoder.drive_mv(state, at(10ms), 5), 1 + 0.5 * (100 - 20));
    EXPECT_EQ(encoder.drive_mv(state, at(20ms), 5.1), 1) << "10 N/s are below the threshold";
    EXPECT_EQ(encoder.drive_mv(state, at(30ms), 1), 1) << "release does not drive";
}

TEST(Encoders, RefuseAGainThatIsNotPositive) {
    EXPECT_THROW(Sustained({.gain_mv_per_n = 0}), ParameterError);
    EXPECT_THROW(Transient({.gain_mv_s_per_n = -1}), ParameterError);
}

TEST(Calibration, IsLinearBetweenPointsAndHeldBeyondThem) {
    const Calibration calibration({{100, 0}, {200, 1}, {400, 9}});
    EXPECT_EQ(calibration.force_n(0), 0);
    EXPECT_EQ(calibration.force_n(100), 0);
    EXPECT_EQ(calibration.force_n(150), 0.5);
    EXPECT_EQ(calibration.force_n(200), 1);
    EXPECT_EQ(calibration.force_n(300), 5);
    EXPECT_EQ(calibration.force_n(400), 9);
    EXPECT_EQ(calibration.force_n(4095), 9);
}

TEST(Calibration, RefusesCountsThatDoNotIncreaseAndForcesThatAreNoNumbers) {
    EXPECT_THROW(Calibration({{100, 0}, {100, 1}}), ParameterError);
    EXPECT_THROW(Calibration({{100, 0}}), ParameterError);
    EXPECT_THROW(Calibration({{100, 0}, {200, std::nan("")}}), ParameterError);
    EXPECT_THROW(Calibration({{100, 0}, {200, HUGE_VAL}}), ParameterError);
}

}  // namespace
}  // namespace afferent
