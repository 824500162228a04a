#include "afferent/decoders/truncated_normal.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace afferent {
namespace {

// By Simpson's rule, relative to the density at the limit nearer to 0.
TruncatedNormal integrated(double low, double high) {
    const double nearest = low > 0 ? low : high < 0 ? high : 0;
    double mass = 0;
    double first = 0;
    double second = 0;
    constexpr int steps = 200'000;
    // What is farther than this is not seen.
    const double from = std::max(low, nearest - 40);
    const double to = std::min(high, nearest + 40);
    const double h = (to - from) / steps;
    for (int i = 0; i <= steps; ++i) {
        const double x = from + i * h;
        const double weight = h / 3 *
                              (i == 0 || i == steps ? 1
                               : i % 2 == 1         ? 4
                                                    : 2) *
                              std::exp(-0.5 * (x * x - nearest * nearest));
        mass += weight;
        first += weight * (x - nearest);
        second += weight * (x - nearest) * (x - nearest);
    }
    const double mean = first / mass;
    return {nearest + mean, second / mass - mean * mean,
            std::log(mass / std::sqrt(2 * std::acos(-1.0))) - 0.5 * nearest * nearest};
}

TEST(TruncatedNormal, HasTheMomentsOfItsDensity) {
    for (const auto& [low, high] :
         {std::pair{-1.0, 2.0}, {-8.0, 0.5}, {-40.0, -4.9}, {-30.0, -9.0}, {6.0, 6.2}, {-3.0, 30.0}}) {
        const TruncatedNormal truth = integrated(low, high);
        const TruncatedNormal cut = truncated_normal(low, high);
        // Simpson's rule with 200,000 steps leaves less.
        EXPECT_NEAR(cut.mean, truth.mean, 1e-6) << low << " to " << high;
        EXPECT_NEAR(cut.variance, truth.variance, 1e-6);
        EXPECT_NEAR(cut.log_mass, truth.log_mass, 1e-6);
    }
}

// An exponential is off by 1/r² at most, a thousandth.
TEST(TruncatedNormal, IsNearlyExponentialFarOut) {
    for (const auto& [low, high] : {std::pair{-70.0, -30.5}, {31.0, 31.02}, {40.0, 90.0}, {-33.0, -32.9}}) {
        const TruncatedNormal truth = integrated(low, high);
        const TruncatedNormal cut = truncated_normal(low, high);
        const double limit = low > 0 ? low : high;
        EXPECT_NEAR(cut.mean - limit, truth.mean - limit, 0.01 * std::abs(truth.mean - limit));
        EXPECT_NEAR(cut.variance, truth.variance, 0.01 * truth.variance);
        EXPECT_NEAR(cut.log_mass, truth.log_mass, 0.01);
    }
}

TEST(TruncatedNormal, IsItsOwnMirrorImage) {
    const TruncatedNormal low = truncated_normal(-7, -6);
    const TruncatedNormal high = truncated_normal(6, 7);
    EXPECT_EQ(high.mean, -low.mean);
    EXPECT_EQ(high.variance, low.variance);
    EXPECT_EQ(high.log_mass, low.log_mass);
}

TEST(TruncatedNormal, IsUniformBetweenLimitsThatAreNear) {
    const TruncatedNormal cut = truncated_normal(1, 1 + 1e-6);
    EXPECT_NEAR(cut.mean, 1 + 0.5e-6, 1e-12);
    EXPECT_NEAR(cut.variance, 1e-12 / 12, 1e-16);
}

}  // namespace
}  // namespace afferent
