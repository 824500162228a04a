#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "afferent/hand/emg_envelope.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/hand/random.hpp"
#include "afferent/hand/sensor.hpp"
#include "afferent/hand/user.hpp"

namespace afferent {
namespace {

TimePoint at(Duration t) { return scene_start + t; }

TEST(Gaussian, HasMeanZeroAndVarianceOne) {
    constexpr int n = 100'000;
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < n; ++i) {
        const double x = gaussian(7, Stream::sensor_noise, 3, static_cast<std::uint64_t>(i));
        sum += x;
        squares += x * x;
    }
    // Five standard errors: 1/sqrt(n) of the mean, sqrt(2/n) of the variance.
    EXPECT_NEAR(sum / n, 0, 5 / std::sqrt(n));
    EXPECT_NEAR(squares / n, 1, 5 * std::sqrt(2.0 / n));
}

TEST(Gaussian, DependsOnSeedStreamAddressAndIndex) {
    const double x = gaussian(1, Stream::sensor_noise, 0, 0);
    EXPECT_EQ(gaussian(1, Stream::sensor_noise, 0, 0), x);
    EXPECT_NE(gaussian(2, Stream::sensor_noise, 0, 0), x);
    EXPECT_NE(gaussian(1, Stream::closing_emg, 0, 0), x);
    EXPECT_NE(gaussian(1, Stream::sensor_noise, 1, 0), x);
    EXPECT_NE(gaussian(1, Stream::sensor_noise, 0, 1), x);
}

// Kolmogorov and Smirnov: the largest distance to the straight line is above 1.95 / √n once in a thousand.
TEST(UniformNumbers, FillTheStretchFromZeroToOne) {
    constexpr std::size_t count = 10'000;
    std::vector<double> numbers;
    for (std::uint32_t i = 0; i < count; ++i) numbers.push_back(uniform(7, Stream::afferent_phase, i, 0));
    std::sort(numbers.begin(), numbers.end());
    EXPECT_GE(numbers.front(), 0);
    EXPECT_LT(numbers.back(), 1);
    for (std::size_t i = 0; i < count; ++i)
        ASSERT_NEAR(numbers[i], static_cast<double>(i) / count, 1.95 / std::sqrt(count));
    EXPECT_NE(uniform(7, Stream::afferent_phase, 3, 0), uniform(7, Stream::afferent_gain, 3, 0));
    EXPECT_NE(uniform(7, Stream::afferent_phase, 3, 0), uniform(7, Stream::afferent_phase, 3, 1));
}

TEST(Sensor, ReadsWholeCountsInProportionToForce) {
    const Sensor sensor({.full_scale_n = 10, .adc_bits = 12});
    Sensor::State state;
    EXPECT_EQ(sensor.counts(state, 0, 0), 0);
    EXPECT_EQ(sensor.counts(state, 10, 0), 4095);
    EXPECT_EQ(sensor.counts(state, 25, 0), 4095) << "beyond full scale";
    EXPECT_EQ(sensor.counts(state, -1, 0), 0);
}

TEST(Sensor, RoundsToTheNearestCountAndTiesUp) {
    const Sensor sensor({.full_scale_n = 4095, .adc_bits = 12});
    Sensor::State state;
    for (const double ties : {0.5, 1.5, 2.5, 2048.5, 4094.5}) {
        EXPECT_EQ(sensor.counts(state, ties, 0), ties + 0.5);
        EXPECT_EQ(sensor.counts(state, ties - 1e-9, 0), ties - 0.5);
    }
}

// 20 kΩ at rest, 10.25 kΩ at 0.8 N and 2.45 kΩ at 7.2 N, over 4.7 kΩ.
TEST(Sensor, ReadsTheDividerOfItsResistance) {
    const Sensor sensor({.full_scale_n = 10, .adc_bits = 12, .force_resistance = Sensor::ForceResistance{}});
    Sensor::State state;
    EXPECT_EQ(sensor.counts(state, 0, 0), std::round(4095 * 4.7 / (4.7 + 20)));
    EXPECT_EQ(sensor.counts(state, 0.8, 0), std::round(4095 * 4.7 / (4.7 + 10.25)));
    EXPECT_EQ(sensor.counts(state, 7.2, 0), std::round(4095 * 4.7 / (4.7 + 2.45)));
    // The inverse of an exact count, to rounding.
    EXPECT_NEAR(sensor.force_n(4095 * 4.7 / (4.7 + 10.25)), 0.8, 1e-12);
}

TEST(Sensor, InvertsItsCurveToHalfACount) {
    const Sensor sensor({.full_scale_n = 10, .adc_bits = 12, .force_resistance = Sensor::ForceResistance{}});
    Sensor::State state;
    double before = -1;
    for (double force = 0; force <= 10; force += 0.25) {
        const double counts = sensor.counts(state, force, 0);
        EXPECT_GT(counts, before);
        before = counts;
        // The force of half a count there, by the slope of the divider: R = 0.5 kΩ + 19.5 kΩ/(1 + F/0.8 N).
        const double squeeze = 1 + force / 0.8;
        const double total_kohm = 4.7 + 0.5 + 19.5 / squeeze;
        const double counts_per_n = 4095 * 4.7 / (total_kohm * total_kohm) * 19.5 / (0.8 * squeeze * squeeze);
        EXPECT_NEAR(sensor.force_n(counts), force, 1.1 * 0.5 / counts_per_n);
    }
}

TEST(Sensor, KnowsTheSpreadOfItsReadings) {
    for (const auto& curve :
         {std::optional<Sensor::ForceResistance>(), std::optional(Sensor::ForceResistance())}) {
        const Sensor sensor({.noise_counts = 2, .force_resistance = curve});
        for (const double force_n : {1.0, 5.0, 9.0}) {
            constexpr int n = 20'000;
            double squares = 0;
            for (int i = 0; i < n; ++i) {
                Sensor::State state;
                const double noise = gaussian(7, Stream::sensor_noise, 3, static_cast<std::uint64_t>(i));
                squares += std::pow(sensor.force_n(sensor.counts(state, force_n, noise)) - force_n, 2);
            }
            // Five standard errors are 2.5 %; the curve bends a little within the noise.
            EXPECT_NEAR(std::sqrt(squares / n), sensor.noise_n(force_n), 0.05 * sensor.noise_n(force_n));
        }
    }
}

TEST(Sensor, ReadsLowLoadingAndHighUnloading) {
    const Sensor sensor({.full_scale_n = 10, .adc_bits = 20, .hysteresis = 0.1});
    Sensor::State state;
    for (double force = 0; force <= 5; force += 0.01) sensor.counts(state, force, 0);
    EXPECT_NEAR(sensor.force_n(sensor.counts(state, 5, 0)), 4.5, 1e-4);
    for (double force = 8; force >= 5; force -= 0.01) sensor.counts(state, force, 0);
    EXPECT_NEAR(sensor.force_n(sensor.counts(state, 5, 0)), 5.5, 1e-4);
    EXPECT_EQ(sensor.counts(state, 0, 0), 0) << "and lets go at rest";
}

TEST(User, ClosesHoldsAndOpens) {
    const User user({.close_at_s = 1, .close_for_s = 2, .hold_for_s = 3, .open_for_s = 1, .effort = 0.5}, 1);
    EXPECT_EQ(user.closing_effort(at(500ms)), 0);
    EXPECT_EQ(user.closing_effort(at(2s)), 0.5);
    EXPECT_EQ(user.closing_effort(at(4s)), 0.05);
    EXPECT_EQ(user.opening_effort(at(4s)), 0);
    EXPECT_EQ(user.opening_effort(at(6500ms)), 0.5);
    EXPECT_EQ(user.closing_effort(at(6500ms)), 0);
}

TEST(EmgEnvelope, RecoversTheEffortOfTheUser) {
    const User user({.close_at_s = 0, .close_for_s = 60, .effort = 0.5}, 1);
    EmgEnvelope envelope({}, 1ms);
    double sum = 0;
    int n = 0;
    for (int k = 0; k < 30'000; ++k) {
        const double value = envelope(user.emg(at(k * 1ms), static_cast<std::uint64_t>(k)).closing_counts);
        if (k >= 1000) {
            sum += value;
            ++n;
        }
    }
    // 0.76 is the spread of |x| over its mean; 29,000 independent samples; five standard errors.
    EXPECT_NEAR(sum / n, 0.5, 5 * 0.5 * 0.76 / std::sqrt(n));
}

TEST(Gripper, ClosesTouchesAndHoldsWithoutCommand) {
    Gripper gripper({.stiffness_n_per_mm = 0.5, .distance_mm = 20});
    for (int k = 0; k < 300; ++k) gripper.advance(1, 1ms);
    EXPECT_EQ(gripper.force_n(), 0) << "60 mm/s for 0.3 s is short of 20 mm";
    for (int k = 0; k < 200; ++k) gripper.advance(1, 1ms);
    EXPECT_GT(gripper.force_n(), 0);
    for (int k = 0; k < 1000; ++k) gripper.advance(0, 1ms);
    const double held = gripper.force_n();
    for (int k = 0; k < 1000; ++k) gripper.advance(0, 1ms);
    EXPECT_NEAR(gripper.force_n(), held, 1e-6);
}

TEST(Gripper, StallsAtItsForceLimit) {
    Gripper gripper({.force_limit_n = 8});
    for (int k = 0; k < 20'000; ++k) {
        gripper.advance(1, 1ms);
        ASSERT_LE(gripper.force_n(), 8 + 1e-9);
    }
    EXPECT_NEAR(gripper.force_n(), 8, 0.1);
    for (int k = 0; k < 2'000; ++k) gripper.advance(-1, 1ms);
    EXPECT_EQ(gripper.position_mm(), 0);
}

// The flow under a held command composes: one step of 10 ms is ten of 1 ms, where load does not change.
TEST(Gripper, IsExactOverAStepInFreeMotion) {
    Gripper once({});
    Gripper often({});
    once.advance(0.7, 10ms);
    for (int k = 0; k < 10; ++k) often.advance(0.7, 1ms);
    EXPECT_NEAR(once.position_mm(), often.position_mm(), 1e-12);
}

TEST(Gripper, DoesNotMoveOnACommandThatIsNotANumber) {
    Gripper gripper({});
    gripper.advance(std::numeric_limits<double>::quiet_NaN(), 1s);
    EXPECT_EQ(gripper.position_mm(), 0);
}

}  // namespace
}  // namespace afferent
