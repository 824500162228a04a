#include "afferent/studies/trial/felt_shares.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace afferent {
namespace {

const std::vector<double> stated{0.2, 0.3, 0.1, 0.4};

double sum(const std::vector<double>& all) { return std::accumulate(all.begin(), all.end(), 0.0); }

// The standard deviation of the logarithm of felt over stated, by element and presentation.
double spread(const scene::TrialSensing& sensing) {
    constexpr std::uint32_t presentations = 5000;
    double squares = 0;
    for (std::uint32_t number = 0; number < presentations; ++number) {
        const auto felt = felt_shares(sensing, stated, 1, number);
        for (std::size_t i = 0; i < stated.size(); ++i) squares += std::pow(std::log(felt[i] / stated[i]), 2);
    }
    return std::sqrt(squares / presentations / static_cast<double>(stated.size()));
}

TEST(FeltShares, AreThoseOfTheSceneWhereItSaysNothing) { EXPECT_EQ(felt_shares({}, stated, 1, 7), stated); }

TEST(FeltShares, DependOnSeedAndPresentationAlone) {
    const scene::TrialSensing sensing{
        .gain_spread = 0.1, .common_gain_spread = 0.1, .share_spread = 0.1, .dead_elements = 1};
    EXPECT_EQ(felt_shares(sensing, stated, 1, 7), felt_shares(sensing, stated, 1, 7));
    EXPECT_NE(felt_shares(sensing, stated, 1, 7), felt_shares(sensing, stated, 1, 8));
    EXPECT_NE(felt_shares(sensing, stated, 1, 7), felt_shares(sensing, stated, 2, 7));
}

// The standard deviation of 20,000 normal numbers is known to 0.5 %; five of those.
TEST(FeltShares, HaveTheGainsSpread) {
    EXPECT_NEAR(spread({.gain_spread = 0.2}), 0.2, 0.2 * 0.025);
    // One number for all elements: a quarter as many.
    EXPECT_NEAR(spread({.common_gain_spread = 0.2}), 0.2, 0.2 * 0.05);
    EXPECT_NEAR(spread({.gain_spread = 0.3, .common_gain_spread = 0.4}), 0.5, 0.5 * 0.05);
}

TEST(FeltShares, HaveOneCommonGain) {
    const auto felt = felt_shares({.common_gain_spread = 0.3}, stated, 1, 3);
    for (std::size_t i = 0; i < stated.size(); ++i)
        EXPECT_NEAR(felt[i] / stated[i], felt[0] / stated[0], 1e-12) << i;
    EXPECT_GT(std::abs(felt[0] / stated[0] - 1), 1e-3);
}

TEST(FeltShares, AreSharedOtherwiseAndNotMore) {
    for (std::uint32_t number = 0; number < 20; ++number) {
        const auto felt = felt_shares({.share_spread = 0.5}, stated, 1, number);
        EXPECT_NEAR(sum(felt), sum(stated), 1e-12) << number;
        EXPECT_GT(std::abs(felt[0] - stated[0]), 1e-6) << number;
    }
    // An element gets e^x of its share of the whole, less what all got: about the stated spread.
    EXPECT_NEAR(spread({.share_spread = 0.1}), 0.1 * std::sqrt(0.75), 0.02);
}

TEST(FeltShares, AreNothingForSoManyDeadElements) {
    std::vector<int> died(stated.size());
    for (std::uint32_t number = 0; number < 400; ++number) {
        const auto felt = felt_shares({.dead_elements = 2}, stated, 1, number);
        EXPECT_EQ(std::ranges::count(felt, 0.0), 2) << number;
        for (std::size_t i = 0; i < felt.size(); ++i) {
            died[i] += felt[i] == 0;
            EXPECT_TRUE(felt[i] == 0 || felt[i] == stated[i]);
        }
    }
    // Each as often as any other: 200 of 400, with a deviation of 10.
    for (const int times : died) EXPECT_NEAR(times, 200, 50);
    EXPECT_EQ(sum(felt_shares({.dead_elements = 9}, stated, 1, 0)), 0);
    EXPECT_TRUE(felt_shares({.share_spread = 1, .dead_elements = 1}, {}, 1, 0).empty());
}

}  // namespace
}  // namespace afferent
