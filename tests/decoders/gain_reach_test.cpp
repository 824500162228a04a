// What keeps a gain from 0 at its limit, and how that is said. Whole scenes are in tests/scene.
#include "afferent/decoders/gain_reach.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/decoders/afferents.hpp"

namespace afferent {
namespace {

TEST(GainReach, NeedsSensorsADecoderAndSpikesInTime) {
    const GainReach reach{
        .limit_n = 10, .sensed_n = 12, .wanted_n = 12, .rate_hz = 4, .longest_wait_s = 0.25, .closes_n = 10};
    EXPECT_TRUE(reach.reaches());
    GainReach less = reach;
    less.sensed_n = 11.9;
    EXPECT_FALSE(less.reaches());
    less = reach;
    less.longest_wait_s = 0.24;
    EXPECT_FALSE(less.reaches());
    less = reach;
    less.closes_n = 20;
    EXPECT_FALSE(less.reaches());
    less.closes_n.reset();
    EXPECT_FALSE(less.reaches());
}

// At 3 N the afferent fires some 40 times a second: a window of 60 ms holds two spikes or three, and three
// for good only at a higher force. One of 0.1 ms is empty between any two spikes. An interval needs no more
// than the next spike.
TEST(GainReach, SaysWhatKeepsADecoderFromIt) {
    DecodedAfferents decoded{.addresses = 1, .largest_grip_n = 40};
    decoded.add(0, group_with(2), 1);
    const EmgGain::Parameters gain{.limit_n = 3};
    const auto why = [&](const DecoderParameters& decoder) {
        return unreachable_limit({decoder, decoded, gain});
    };
    const std::string late = why(SlidingWindowParameters{.window = 60ms});
    EXPECT_NE(
        late.find("a window of 60 ms holds as few as 2 of the spikes: the gain is 0 for good only from "),
        std::string::npos)
        << late;
    const std::string never = why(SlidingWindowParameters{.window = 100us});
    EXPECT_NE(never.find(" % of the time: no force brings the gain to 0 for good"), std::string::npos)
        << never;
    EXPECT_EQ(why(InverseIntervalParameters()), "");
}

TEST(GainReach, SaysWhatTheSensorsWouldHaveToRead) {
    DecodedAfferents decoded{.addresses = 2, .largest_grip_n = 10, .uncertainty = Uncertainty::none()};
    decoded.uncertainty.gain = 0.1;
    for (const auto& [address, share] : {std::pair{0U, 0.8}, std::pair{1U, 0.2}}) {
        DecodedAfferents::Group group = group_with(2);
        group.full_scale_n = 10;
        decoded.add(address, group, share);
    }
    const double limit_n = 0.98 * 10;
    const GainLoop loop{FilterParameters(), decoded, {.onset_n = 0, .limit_n = limit_n}};
    EXPECT_DOUBLE_EQ(gain_reach(loop).sensed_n, limit_n) << "just the limit";
    EXPECT_DOUBLE_EQ(gain_reach(loop).wanted_n, limit_n * (1 + 2 * 0.1 * std::sqrt(0.8 * 0.8 + 0.2 * 0.2)));
    EXPECT_TRUE(unreachable_limit(loop).ends_with(
        "the sensors read 9.8 N at most, and as well as they are known they have to read 11.4 N"))
        << unreachable_limit(loop);
}

// At the limit the afferent fires twice a second, so that half a second passes without a word.
TEST(GainReach, SaysHowLongAForceMayRiseUnnoticed) {
    DecodedAfferents decoded{.addresses = 1, .largest_grip_n = 40};
    decoded.add(0, group_with(2), 1);
    const double limit_n = decoded.groups[0].grip_n(RateKind::steady, 2);
    const std::string why =
        unreachable_limit({FilterParameters(), decoded, {.onset_n = 0, .limit_n = limit_n}});
    EXPECT_TRUE(why.ends_with(", and a force may rise unnoticed for 0.5 s")) << why;
}

}  // namespace
}  // namespace afferent
