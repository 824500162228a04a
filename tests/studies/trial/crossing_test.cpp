#include "afferent/studies/trial/crossing.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace afferent {
namespace {

// Each presentation breaks above a threshold of its own; their medians are at 3 and they spread as a logistic
// distribution, so that the crossing of every target is known.
struct Thresholds {
    double steepness = 2;  // < 0: it falls with the parameter
    int counts = 0;

    double crossing_of(double target) const { return 3 * std::pow(target / (1 - target), 1 / steepness); }
    std::optional<Proportion> operator()(double parameter, std::uint32_t presentations) {
        ++counts;
        Proportion broken{0, presentations};
        for (std::uint32_t i = 0; i < presentations; ++i) {
            // The golden ratio's multiples lie evenly in [0, 1).
            const double u = std::fmod(0.5 + i * 0.6180339887498949, 1.0);
            const double threshold = 3 * std::pow(u / (1 - u), 1 / steepness);
            if ((parameter - threshold) * steepness > 0) ++broken.hits;
        }
        return broken;
    }
};

TEST(Crossing, IsFoundToItsToleranceInFewCounts) {
    for (const double steepness : {-4.0, 0.7, 2.0, 20.0})
        for (const double target : {0.02, 0.14, 0.275, 0.8}) {
            Thresholds thresholds{steepness};
            const double truth = thresholds.crossing_of(target);
            const auto found = find_crossing(
                {.low = truth / 7, .high = truth * 4, .target = target, .presentations = 20'000},
                std::ref(thresholds));
            ASSERT_TRUE(found);
            EXPECT_TRUE(found->is_reached);
            EXPECT_NEAR(found->counted.value(), target, 0.001) << steepness;
            EXPECT_LE(thresholds.counts, 20) << steepness << ' ' << target;
            // A proportion within 0.001 of the target, over the steepness of the curve there.
            const double tolerance = 0.001 / (target * (1 - target) * std::abs(steepness) / truth);
            EXPECT_NEAR(found->parameter, truth, 2 * tolerance) << steepness << ' ' << target;
            // Counting leaves as much open as 20,000 independent presentations do.
            const double sigma = std::sqrt(target * (1 - target) / 20'000) * tolerance / 0.001;
            EXPECT_NEAR(found->sigma / sigma, 1, 0.35) << "its slope is that of a chord";
        }
}

TEST(Crossing, SaysThatTheRangeDoesNotReachTheTarget) {
    Thresholds thresholds;
    const auto found =
        find_crossing({.low = 0.1, .high = 1, .target = 0.5, .presentations = 1000}, std::ref(thresholds));
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->is_reached);
    EXPECT_DOUBLE_EQ(found->parameter, 1);
}

TEST(Crossing, EndsWhereACountIsInterrupted) {
    for (int last = 0; last < 4; ++last) {
        Thresholds thresholds;
        const auto found = find_crossing(
            {.low = 0.1, .high = 20, .target = 0.275, .presentations = 20'000},
            [&](double parameter, std::uint32_t presentations) {
                return thresholds.counts == last ? std::nullopt : thresholds(parameter, presentations);
            });
        EXPECT_FALSE(found) << last;
        EXPECT_EQ(thresholds.counts, last);
    }
}

}  // namespace
}  // namespace afferent
