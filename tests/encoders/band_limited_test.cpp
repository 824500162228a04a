// The band-limited encoders against closed forms.
#include "afferent/encoders/band_limited.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

#include "afferent/encoders/sustained.hpp"
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

// A settled sine of amplitude 1, behind the lags: their response at ω is (iω / (1 + iω/w)²)ⁿ.
template <class E>
double sine_behind_lags(double frequency_hz, double t) {
    const double omega = 2 * std::numbers::pi * frequency_hz;
    const double ratio = frequency_hz / corner_hz;
    constexpr int order = std::is_same_v<E, BandTransient> ? 1 : 2;
    const double amplitude = std::pow(omega / (1 + ratio * ratio), order);
    return amplitude * std::sin(omega * t + order * (std::numbers::pi / 2 - 2 * std::atan(ratio)));
}

TYPED_TEST(BandLimitedRamp, RectifiesASineAsAClosedForm) {
    constexpr double frequency_hz = 50;
    constexpr double step_s = 2e-6;
    constexpr int order = std::is_same_v<TypeParam, BandTransient> ? 1 : 2;
    const double amplitude =
        std::pow(2 * std::numbers::pi * frequency_hz / (1 + std::pow(frequency_hz / corner_hz, 2)), order);
    for (const double negative_ratio : {0.0, 0.3, 1.0})
        for (const double threshold : {0.0, 0.4 * amplitude}) {
            const TypeParam encoder({.gain = 2,
                                     .bias_mv = 1,
                                     .corner_hz = corner_hz,
                                     .rectification = {negative_ratio, threshold}});
            typename TypeParam::State state;
            double sum = 0;
            int steps = 0;
            double worst = 0;
            // The lags forget by e^(−2π 80 · 0.1) = 1e-22.
            for (int i = 0; i * step_s < 0.1 + 1 / frequency_hz; ++i) {
                const double t = i * step_s;
                const double drive =
                    encoder.drive_mv(state, after(t), std::sin(2 * std::numbers::pi * frequency_hz * t));
                if (t < 0.1) continue;
                const double x = sine_behind_lags<TypeParam>(frequency_hz, t);
                const double expected =
                    1 + 2 * (x < 0 ? negative_ratio : 1) * std::max(0.0, std::abs(x) - threshold);
                worst = std::max(worst, std::abs(drive - expected));
                sum += drive - 1;
                ++steps;
            }
            // A line cuts a sine by (2π f step)²/8 of its height; the lags' sums round by 1e-9.
            EXPECT_LT(worst, 1e-6 * amplitude) << negative_ratio << " " << threshold;
            // The mean of one half-wave of a sine is 1/π of its height.
            if (threshold == 0) {
                EXPECT_NEAR(sum / steps, 2 * amplitude * (1 + negative_ratio) / std::numbers::pi,
                            1e-4 * amplitude);
            }
        }
}

// The rate behind two lags of a force that rises along a line is its slope times 1 − e^(−s) (1 + s).
TEST(DynamicSustained, AddsTheRiseOfAForceAndNotItsFall) {
    const DynamicSustained encoder({.gain_mv_per_n = 3, .bias_mv = 2, .time = 40ms, .corner_hz = corner_hz});
    constexpr double slope_n_per_s = 5;
    for (const double step_s : {1e-5, 1e-3}) {
        DynamicSustained::State state;
        EXPECT_EQ(encoder.drive_mv(state, scene_start, 0), 2);
        for (int i = 1; i * step_s < 0.03; ++i) {
            const double t = i * step_s;
            const double rate = slope_n_per_s * response_to_ramp<BandTransient>(corner_per_s * t);
            const double expected = 2 + 3 * (slope_n_per_s * t + 0.04 * rate);
            EXPECT_NEAR(encoder.drive_mv(state, after(t), slope_n_per_s * t), expected, 1e-9 * expected);
        }
        // Long after the line has ended, force alone drives; and from then on while it falls.
        encoder.drive_mv(state, after(0.03), 0.15);
        EXPECT_NEAR(encoder.drive_mv(state, after(1), 0.15), 2 + 3 * 0.15, 1e-9);
        for (int i = 1; i < 20; ++i) {
            const double force_n = 0.15 - 0.005 * i;
            EXPECT_NEAR(encoder.drive_mv(state, after(1 + i * 1e-3), force_n), 2 + 3 * force_n, 1e-9);
        }
    }
}

TEST(DynamicSustained, RefusesATimeThatIsNotPositive) {
    const DynamicSustained::Parameters good{1, 0, 1ms, 50};
    EXPECT_NO_THROW(good.check());
    for (const Seconds bad : {Seconds(0), Seconds(-1), Seconds(std::nan(""))})
        EXPECT_THROW((DynamicSustained({1, 0, bad, 50})), ParameterError);
    EXPECT_THROW((DynamicSustained({1, 0, 1ms, 0})), ParameterError);
    EXPECT_THROW((DynamicSustained({0, 0, 1ms, 50})), ParameterError);
    EXPECT_FALSE(good.decodable());
}

using SlowSustained = SlowlyAdapting<Sustained>;

// y of a step is F (1 − e^(−t/τ)), however often it is sampled; of a ramp from 0 on, slope (t − τ (1 −
// e^(−t/τ))).
TEST(SlowlyAdapting, LeavesOfAHeldForceAllButItsPart) {
    const SlowSustained encoder({{.gain_mv_per_n = 3, .bias_mv = 2}, 0.4, Seconds(5)});
    for (const double step_s : {0.005, 1.0, 40.0}) {
        SlowSustained::State state;
        EXPECT_DOUBLE_EQ(encoder.drive_mv(state, scene_start, 7), 2 + 3 * 7);
        for (double t = step_s; t <= 40; t += step_s) {
            const double left = 1 - 0.4 * (1 - std::exp(-t / 5));
            EXPECT_NEAR(encoder.drive_mv(state, after(t), 7), 2 + 3 * 7 * left, 1e-9);
        }
    }
    for (const double step_s : {0.01, 2.5}) {
        SlowSustained::State state;
        encoder.drive_mv(state, scene_start, 0);
        for (double t = step_s; t <= 10; t += step_s) {
            const double y = 0.5 * (t - 5 * (1 - std::exp(-t / 5)));
            EXPECT_NEAR(encoder.drive_mv(state, after(t), 0.5 * t), 2 + 3 * (0.5 * t - 0.4 * y), 1e-9);
        }
    }
}

TEST(SlowlyAdapting, DoesNotDriveBelowRestAndForgetsUnsampled) {
    const SlowSustained encoder({{.gain_mv_per_n = 3, .bias_mv = 2}, 0.4, Seconds(5)});
    SlowSustained::State state;
    encoder.drive_mv(state, scene_start, 7);
    encoder.drive_mv(state, after(1000), 7);
    EXPECT_DOUBLE_EQ(encoder.drive_mv(state, after(1000.001), 0), 2);
    // 10 s later e^(−2) of what it had adapted to is left.
    EXPECT_DOUBLE_EQ(encoder.drive_mv(state, after(1010.001), 0), 2);
    EXPECT_NEAR(encoder.drive_mv(state, after(1010.0010001), 7), 2 + 3 * 7 * (1 - 0.4 * std::exp(-2.0)),
                2e-3);
}

// What rises has had no time to adapt: the dynamic term is nearly that of the encoder without it.
TEST(SlowlyAdapting, LeavesTheDynamicTermOfAQuickRise) {
    const DynamicSustained::Parameters quick{3, 2, 40ms, corner_hz};
    const DynamicSustained without(quick);
    const SlowlyAdapting<DynamicSustained> with({quick, 0.4, Seconds(5)});
    DynamicSustained::State state;
    SlowlyAdapting<DynamicSustained>::State slow;
    for (int i = 0; i <= 50; ++i) {
        const double expected = without.drive_mv(state, after(i * 1e-3), 0.1 * i);
        EXPECT_NEAR(with.drive_mv(slow, after(i * 1e-3), 0.1 * i), expected, 0.005 * expected) << i;
    }
}

TEST(SlowlyAdapting, RefusesAPartOutsideZeroToOneAndATimeThatIsNotPositive) {
    const auto encoder = [](double gain, double part, Seconds time) {
        return SlowSustained({{gain, 0}, part, time});
    };
    EXPECT_NO_THROW(encoder(1, 0.5, 1s));
    for (const double bad : {0.0, 1.0, -0.1, 1.1, std::nan("")})
        EXPECT_THROW(encoder(1, bad, 1s), ParameterError);
    for (const Seconds bad : {Seconds(0), Seconds(-1), Seconds(std::nan(""))})
        EXPECT_THROW(encoder(1, 0.5, bad), ParameterError);
    EXPECT_THROW(encoder(0, 0.5, 1s), ParameterError);
    EXPECT_FALSE(SlowSustained::Parameters::decodable());
}

TEST(BandLimited, RefusesACornerThatIsNotPositive) {
    EXPECT_THROW(Vibration({.gain = 1, .bias_mv = 0, .corner_hz = 0}), ParameterError);
    EXPECT_THROW(BandTransient({.gain = 1, .bias_mv = 0, .corner_hz = std::nan("")}), ParameterError);
}

}  // namespace
}  // namespace afferent
