#include "afferent/studies/trial/proportion_interval.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace afferent {
namespace {

// 95 % of a normal distribution lie within so many of its standard deviations.
constexpr double deviations_95 = 1.959963984540054;

// The probability of a binomial count, by logarithms, because n! overflows a double.
double probability_of_count(std::uint64_t hits, std::uint64_t of, double p) {
    const double n = static_cast<double>(of);
    const double k = static_cast<double>(hits);
    return std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(p) +
                    (n - k) * std::log1p(-p));
}

TEST(ProportionInterval, EndsWhereTheCountIsAsFarOffAs95PercentAllow) {
    for (const Proportion counted :
         {Proportion{55, 200}, Proportion{28, 200}, Proportion{1, 30}, Proportion{19'000, 20'000}}) {
        const Bounds interval = interval_95(counted);
        for (const double p : {interval.low, interval.high}) {
            const double sd = std::sqrt(p * (1 - p) / static_cast<double>(counted.of));
            // Rounding of a quotient of nearly equal numbers: no more digits than these are lost.
            EXPECT_NEAR(std::abs(counted.value() - p) / sd, deviations_95, 1e-9);
        }
        EXPECT_TRUE(interval.holds(counted.value()));
    }
}

TEST(ProportionInterval, IsMirroredWhereHitsAndMissesChangePlaces) {
    for (std::uint64_t hits = 0; hits <= 40; ++hits) {
        const Bounds one = interval_95({hits, 40});
        const Bounds other = interval_95({40 - hits, 40});
        EXPECT_NEAR(one.low, 1 - other.high, 1e-15);
        EXPECT_NEAR(one.high, 1 - other.low, 1e-15);
    }
}

TEST(ProportionInterval, ReachesTheEndsAndHoldsAllWhereNothingWasCounted) {
    EXPECT_EQ(interval_95({0, 200}).low, 0);
    EXPECT_GT(interval_95({0, 200}).high, 0);
    EXPECT_EQ(interval_95({200, 200}).high, 1);
    EXPECT_EQ(interval_95({0, 0}).low, 0);
    EXPECT_EQ(interval_95({0, 0}).high, 1);
}

TEST(ProportionInterval, HoldsTheTruthIn95Of100Cases) {
    for (const double p : {0.02, 0.14, 0.275, 0.9}) {
        double covered = 0;
        for (std::uint64_t hits = 0; hits <= 200; ++hits)
            if (interval_95({hits, 200}).holds(p)) covered += probability_of_count(hits, 200, p);
        // Counts are whole, so that no interval covers exactly 95 %; Wilson's is within 2 % from p = 0.02 on
        // (Agresti and Coull, Am. Stat. 1998).
        EXPECT_NEAR(covered, 0.95, 0.02) << p;
    }
}

PairedCount counted(std::uint64_t both, std::uint64_t first, std::uint64_t second, std::uint64_t neither) {
    return {both, first, second, neither};
}

TEST(PairedCount, SortsPresentationsByWhatCameOutUnderEach) {
    PairedCount count;
    count.add(true, true);
    count.add(true, false);
    count.add(true, false);
    count.add(false, true);
    count.add(false, false);
    EXPECT_EQ(count.first().hits, 3U);
    EXPECT_EQ(count.second().hits, 2U);
    EXPECT_EQ(count.of(), 5U);
}

TEST(PairedCount, KnowsADifferenceBetterThanUnpairedCounts) {
    const PairedCount alike = counted(250, 40, 10, 700);
    const auto found = difference(alike);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, 0.26 - 0.29, 1e-15);
    // McNemar's variance, as the variance of a sum of +1, -1 and 0.
    const double variance = (50 - 30.0 * 30.0 / 1000) / 1000;
    EXPECT_NEAR(found->interval.high - found->value, deviations_95 * std::sqrt(variance / 1000), 1e-12);
    const auto half = [](double p) { return deviations_95 * std::sqrt(p * (1 - p) / 1000); };
    EXPECT_LT(found->interval.high - found->value, std::hypot(half(0.29), half(0.26)));
    EXPECT_FALSE(difference({}));
}

TEST(PairedCount, RatioTellsHowManyAreLeft) {
    const auto halved = ratio(counted(150, 150, 0, 700));
    ASSERT_TRUE(halved);
    EXPECT_DOUBLE_EQ(halved->value, 0.5);
    EXPECT_NEAR(halved->interval.low * halved->interval.high, 0.25, 1e-12) << "symmetric in the logarithm";
    const auto same = ratio(counted(200, 0, 0, 800));
    ASSERT_TRUE(same);
    EXPECT_EQ(same->interval.low, 1) << "pairs that all agree leave no doubt";
    EXPECT_EQ(same->interval.high, 1);
    EXPECT_FALSE(ratio(counted(0, 5, 0, 10)));
    EXPECT_FALSE(ratio(counted(0, 0, 5, 10)));
}

// Newcombe (Stat. Med. 17:873, 1998), table II, method 10: 56/70 less 48/80 is 0.2000, 0.0524 to 0.3339.
TEST(Difference, OfPresentationsWithNothingInCommonIsNewcombes) {
    const auto found = difference(Proportion{48, 80}, Proportion{56, 70});
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->value, 0.2, 1e-12);
    EXPECT_NEAR(found->interval.low, 0.0524, 5e-5);
    EXPECT_NEAR(found->interval.high, 0.3339, 5e-5);
    EXPECT_FALSE(difference(Proportion{0, 0}, Proportion{1, 2}));
    EXPECT_FALSE(difference(Proportion{1, 2}, Proportion{0, 0}));
}

}  // namespace
}  // namespace afferent
