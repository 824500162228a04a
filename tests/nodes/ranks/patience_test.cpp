#include "afferent/nodes/ranks/patience.hpp"

#include <gtest/gtest.h>

namespace afferent::ranks {
namespace {

// Two sleeps before the fourth look would take a tenth of a millisecond at least. A busy machine may take the
// processor away for longer, but not each time.
TEST(RankPatience, SleepsInALongWait) {
    int looks = 0;
    const auto begin = Clock::now();
    EXPECT_TRUE(wait({}, [&] {
        const auto waited = Clock::now() - begin;
        if (waited > std::chrono::milliseconds(2)) ++looks;
        return waited > std::chrono::milliseconds(12);
    }));
    // In ten milliseconds, and one more at each end.
    EXPECT_LE(looks, 202);
}

TEST(RankPatience, EndsWithItsLimitAndSoonerOnceInterrupted) {
    const auto never = [] { return false; };
    Patience patience;
    patience.longest = std::chrono::milliseconds(1);
    EXPECT_FALSE(wait(patience, never));
    patience.longest = std::chrono::seconds(2);
    patience.interrupted = [] { return true; };
    patience.once_interrupted = std::chrono::milliseconds(1);
    const auto begin = Clock::now();
    EXPECT_FALSE(wait(patience, never));
    EXPECT_LT(Clock::now() - begin, patience.longest);
}

}  // namespace
}  // namespace afferent::ranks
