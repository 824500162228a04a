#include "afferent/nodes/ranks/partition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

namespace afferent::ranks {
namespace {

using Boundaries = std::vector<std::size_t>;

double most_loaded(const std::vector<double>& loads, const Boundaries& boundaries, double extra) {
    double most = 0;
    for (std::size_t rank = 0; rank + 1 < boundaries.size(); ++rank) {
        const auto at = [&](std::size_t i) {
            return loads.begin() + static_cast<std::ptrdiff_t>(boundaries[i]);
        };
        most = std::max(most, std::accumulate(at(rank), at(rank + 1), rank == 0 ? extra : 0.0));
    }
    return most;
}

// Of all ways to cut, by trying them.
double best(const std::vector<double>& loads, std::size_t begin, std::size_t ranks, double extra) {
    double sum = extra;
    if (ranks == 1)
        return std::accumulate(loads.begin() + static_cast<std::ptrdiff_t>(begin), loads.end(), sum);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t end = begin;; ++end) {
        least = std::min(least, std::max(sum, best(loads, end, ranks - 1, 0)));
        if (end == loads.size()) return least;
        sum += loads[end];
    }
}

TEST(Partition, SharesEqualLoadsEqually) {
    EXPECT_EQ(cut(std::vector<double>(8, 1.0), 4), (Boundaries{0, 2, 4, 6, 8}));
    EXPECT_EQ(cut(std::vector<double>{5}, 1), (Boundaries{0, 1}));
}

TEST(Partition, GivesLessToTheRankThatHasMoreToDo) {
    EXPECT_EQ(cut(std::vector<double>(8, 1.0), 2, 2), (Boundaries{0, 3, 8}));
    EXPECT_EQ(cut(std::vector<double>(8, 1.0), 2, 100), (Boundaries{0, 0, 8}));
    EXPECT_EQ(cut(std::vector<double>(3, 1.0), 2), (Boundaries{0, 1, 3}));
}

TEST(Partition, LeavesRanksWithoutPiecesWhereThereAreTooFew) {
    const Boundaries boundaries = cut(std::vector<double>{1, 1}, 5);
    ASSERT_EQ(boundaries.size(), 6U);
    EXPECT_EQ(boundaries.front(), 0U);
    EXPECT_EQ(boundaries.back(), 2U);
    EXPECT_TRUE(std::is_sorted(boundaries.begin(), boundaries.end()));
    EXPECT_EQ(most_loaded({1, 1}, boundaries, 0), 1);
    EXPECT_EQ(cut(std::vector<double>{}, 3), (Boundaries{0, 0, 0, 0}));
}

// The bound on the load is found to a part in 1e9; loads here differ by more.
TEST(Partition, LoadsTheMostLoadedRankAsLittleAsAnyCut) {
    std::mt19937 random(7);
    std::exponential_distribution<double> load(1);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<double> loads(random() % 9);
        for (double& each : loads) each = random() % 4 == 0 ? 0 : load(random);
        const std::size_t ranks = 1 + random() % 4;
        const double extra = trial % 2 == 0 ? 0 : load(random);
        const Boundaries boundaries = cut(loads, ranks, extra);
        ASSERT_EQ(boundaries.size(), ranks + 1);
        EXPECT_NEAR(most_loaded(loads, boundaries, extra), best(loads, 0, ranks, extra), 1e-8);
    }
}

TEST(Partition, GoesByCountsForAThousandthOfTheLoad) {
    const std::vector<double> counts{1, 3};
    const std::vector<double> loads = with_counts({2, 0}, counts);
    EXPECT_DOUBLE_EQ(loads.at(0), 2.0005);
    EXPECT_DOUBLE_EQ(loads.at(1), 0.0015);
    EXPECT_EQ(with_counts({0, 0}, counts), (std::vector<double>{0.25, 0.75}));
}

}  // namespace
}  // namespace afferent::ranks
