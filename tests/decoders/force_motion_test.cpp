// The motion of a force over a step equals that over its two halves, and over a short step that of theory.
#include "afferent/decoders/force_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace afferent {
namespace {

// By the first step and then the second.
ForceFlow after(const ForceFlow& first, const ForceFlow& second) {
    const auto& [a, b, c, d, ff, fv, vv] = second;
    return {.a = a * first.a + b * first.c,
            .b = a * first.b + b * first.d,
            .c = c * first.a + d * first.c,
            .d = c * first.b + d * first.d,
            .ff = a * a * first.ff + 2 * a * b * first.fv + b * b * first.vv + ff,
            .fv = a * c * first.ff + (a * d + b * c) * first.fv + b * d * first.vv + fv,
            .vv = c * c * first.ff + 2 * c * d * first.fv + d * d * first.vv + vv};
}

void expect_near(double value, double expected, double tolerance) {
    EXPECT_NEAR(value, expected, tolerance * std::abs(expected));
}

constexpr ForceMotion motion{.speed_n_per_s = 30, .time_s = 0.1, .drift_n2_per_s = 0.002, .leaves_per_s = 1};

// From steps that are short against the time constant, for which there are series, to long ones. The series
// of `ff` is cut after the fifth power of 0.2, and the functions cancel to r^3/2^53.
TEST(ForceMotion, WandersTheSameInTwoHalvesOfAStep) {
    for (const double r : {1e-4, 0.01, 0.1, 0.199, 0.3, 1.0, 7.0}) {
        SCOPED_TRACE(r);
        const ForceFlow half = wandering(motion, r / 2 * motion.time_s);
        const ForceFlow once = wandering(motion, r * motion.time_s);
        const ForceFlow twice = after(half, half);
        constexpr double tolerance = 1e-6;
        EXPECT_EQ(once.a, 1);
        EXPECT_EQ(once.c, 0);
        expect_near(twice.b, once.b, tolerance);
        expect_near(twice.d, once.d, tolerance);
        expect_near(twice.ff, once.ff, tolerance);
        expect_near(twice.fv, once.fv, tolerance);
        expect_near(twice.vv, once.vv, tolerance);
    }
}

// A rate of change that lasts through the step moves the force by its square.
TEST(ForceMotion, DriftsAndWandersAsTheoryHasItForAShortStep) {
    const double dt_s = 1e-4 * motion.time_s;
    const ForceFlow flow = wandering(motion, dt_s);
    const double vv = 2 * 30.0 * 30.0 * 1e-4;
    expect_near(flow.vv, vv, 2e-4);
    expect_near(flow.fv, vv * dt_s / 2, 2e-4);
    expect_near(flow.ff, vv * dt_s * dt_s / 3 + 0.002 * dt_s, 2e-4);
}

TEST(ForceMotion, ReturnsTheSameInTwoHalvesOfAStep) {
    for (const double r : {1e-4, 0.1, 0.3, 1.0, 7.0}) {
        SCOPED_TRACE(r);
        const ForceFlow half = returning(motion, r / 2 * motion.time_s);
        const ForceFlow once = returning(motion, r * motion.time_s);
        const ForceFlow twice = after(half, half);
        constexpr double tolerance = 1e-6;
        expect_near(twice.a, once.a, tolerance);
        expect_near(twice.b, once.b, tolerance);
        expect_near(twice.c, once.c, tolerance);
        expect_near(twice.d, once.d, tolerance);
    }
}

TEST(ForceMotion, LosesAFractionThatIsOneMinusTheExponential) {
    for (const double r : {0.0, 1e-9, 0.05, 0.2, 0.2001, 3.0})
        EXPECT_NEAR(lost_fraction(r), -std::expm1(-r), 1e-9 * r)
            << "the series is cut after its seventh power";
}

}  // namespace
}  // namespace afferent
