#include "afferent/nodes/step_lateness.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace afferent {
namespace {

TEST(StepLateness, IsNothingBeforeTheFirst) {
    const StepLateness lateness;
    EXPECT_EQ(lateness.quantile(0.5), Duration::zero());
    EXPECT_EQ(lateness.max(), Duration::zero());
}

TEST(StepLateness, IsWithinASixteenthOfTheTrueQuantiles) {
    std::mt19937_64 random(1);
    std::lognormal_distribution<double> lag_us(3, 2);
    StepLateness lateness;
    std::vector<Duration> all;
    for (int i = 0; i < 20'000; ++i) {
        const Duration late(static_cast<std::int64_t>(lag_us(random) * 1e3));
        all.push_back(late);
        lateness.add(late);
    }
    std::sort(all.begin(), all.end());
    for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
        const Duration exact = all[static_cast<std::size_t>(share * 20'000)];
        const Duration found = lateness.quantile(share);
        EXPECT_GE(found, exact) << share;
        EXPECT_LE(found, exact + exact / 16 + 64ns) << share;
    }
    EXPECT_EQ(lateness.quantile(1), all.back());
    EXPECT_EQ(lateness.max(), all.back());
}

TEST(StepLateness, TakesAnyDuration) {
    StepLateness lateness;
    lateness.add(-1s);
    lateness.add(Duration(24h));
    EXPECT_EQ(lateness.count(), 2U);
    EXPECT_EQ(lateness.max(), Duration(24h));
}

}  // namespace
}  // namespace afferent
