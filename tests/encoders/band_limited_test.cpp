// The band-limited encoders against closed forms.
#include "afferent/encoders/band_limited.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double corner_hz = 80;
constexpr double corner_per_s = 2 * std::numbers::pi * corner_hz;

TimePoint after(double seconds) { return scene_start + rounded(Seconds(seconds)); }

// A force rises from 0 along a line: n lags respond to its corner with the gamma density of order n, and to
// the line's slope with the integral of that.
template <class E>
double response_to_ramp(double s);
template <>
double response_to_ramp<BandTransient>(double s) {
    return 1 - std::exp(-s) * (1 + s);
}
template <>
double response_to_ramp<Vibration>(double s) {
    return corner_per_s * std::exp(-s) * s * s * s / 6;
}

template <class E>
class BandLimitedRamp : public testing::Test {};
using BandLimitedTypes = testing::Types<BandTransient, Vibration>;
TYPED_TEST_SUITE(BandLimitedRamp, BandLimitedTypes);

TYPED_TEST(BandLimitedRamp, IsTheGammaDensityHoweverItIsSampled) {
    const TypeParam encoder({.gain = 2, .bias_mv = 1, .corner_hz = corner_hz});
    constexpr double slope_n_per_s = 5;
    for (const double step_s : {1e-5, 1e-3, 4e-3}) {
        typename TypeParam::State state;
        encoder.drive_mv(state, scene_start, 0);
        for (int i = 1; i * step_s < 0.03; ++i) {
            const double t = i * step_s;
            const double expected = 1 + 2 * slope_n_per_s * response_to_ramp<TypeParam>(corner_per_s * t);
            // Rounding: each of 3,000 steps adds and subtracts the ramp's lag, slope/w, which the second
            // derivative multiplies by w².
            EXPECT_NEAR(encoder.drive_mv(state, after(t), slope_n_per_s * t), expected,
                        1e-9 * std::abs(expected) + 1e-9)
                << t << " s in steps of " << step_s << " s";
        }
    }
}

TYPED_TEST(BandLimitedRamp, ForgetsALongHoldAndAnswersReleaseAsOnset) {
    const TypeParam encoder({.gain = 1, .bias_mv = 0, .corner_hz = corner_hz});
    typename TypeParam::State state;
    encoder.drive_mv(state, after(0), 0);
    const double onset = encoder.drive_mv(state, after(0.002), 1);
    EXPECT_GT(onset, 0);
    EXPECT_LT(encoder.drive_mv(state, after(10), 1), 1e-12);
    EXPECT_EQ(encoder.drive_mv(state, after(1e6), 1), 0);
    EXPECT_NEAR(encoder.drive_mv(state, after(1e6 + 0.002), 0), onset, 1e-9 * onset);
}

// The largest drive of a settled sine, sampled so densely that straight lines between samples are the sine
// itself.
template <class E>
double amplitude(double frequency_hz) {
    const E encoder({.gain = 1, .bias_mv = 0, .corner_hz = corner_hz});
    typename E::State state;
    double largest = 0;
    constexpr double step_s = 2e-6;
    const double settled_s = 0.05;
    for (int i = 0; i * step_s < settled_s + 1 / frequency_hz; ++i) {
        const double t = i * step_s;
        const double drive =
            encoder.drive_mv(state, after(t), std::sin(2 * std::numbers::pi * frequency_hz * t));
        if (t > settled_s) largest = std::max(largest, drive);
    }
    return largest;
}

TEST(BandLimited, HasItsBestFrequencyAtTheCorner) {
    for (const double ratio : {0.25, 0.5, 1.0, 2.0, 4.0}) {
        const double frequency_hz = ratio * corner_hz;
        const double of_force = 2 * std::numbers::pi * frequency_hz / (1 + ratio * ratio);
        // A line cuts a sine by (2π f step)²/8, and a top is missed by as much.
        EXPECT_NEAR(amplitude<BandTransient>(frequency_hz) / of_force, 1, 1e-4) << ratio;
        EXPECT_NEAR(amplitude<Vibration>(frequency_hz) / (of_force * of_force), 1, 1e-4) << ratio;
    }
}

TEST(BandLimited, RefusesACornerThatIsNotPositive) {
    EXPECT_THROW(Vibration({.gain = 1, .bias_mv = 0, .corner_hz = 0}), ParameterError);
    EXPECT_THROW(BandTransient({.gain = 1, .bias_mv = 0, .corner_hz = std::nan("")}), ParameterError);
}

}  // namespace
}  // namespace afferent
