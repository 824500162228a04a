#include "afferent/decoders/afferent_roster.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

using Standing = AfferentRoster::Standing;

std::vector<std::uint32_t> order(const AfferentRoster& roster) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t index = roster.first(); index != AfferentRoster::end; index = roster.next(index))
        found.push_back(index);
    return found;
}

TEST(AfferentRoster, KeepsTheOrderOfTheLastSpikes) {
    AfferentRoster roster(3);
    EXPECT_TRUE(order(roster).empty());
    for (const std::uint32_t index : {0, 1, 2, 0}) roster.append(index);
    EXPECT_EQ(order(roster), (std::vector<std::uint32_t>{1, 2, 0}));
    EXPECT_EQ(roster.last(), 0);
    EXPECT_EQ(roster.previous(0), 2);
    roster.prepend(2);
    EXPECT_EQ(order(roster), (std::vector<std::uint32_t>{2, 1, 0}));
}

TEST(AfferentRoster, WhoIsNotListenedToIsNotInIt) {
    AfferentRoster roster(3);
    for (const std::uint32_t index : {0, 1, 2}) roster.append(index);
    roster.remove(1, Standing::dead);
    roster.remove(1, Standing::rejected);
    EXPECT_EQ(order(roster), (std::vector<std::uint32_t>{0, 2}));
    EXPECT_EQ(roster.listed(), 2);
    EXPECT_EQ(roster[1].standing, Standing::rejected);
    AfferentRoster other(3);
    other.resume(roster.snapshot());
    EXPECT_EQ(order(other), order(roster));
    EXPECT_EQ(other.listed(), 2);
}

}  // namespace
}  // namespace afferent
