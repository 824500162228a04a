// Brake and pulse in one hand. What each does by itself is in contact_reflex_test and slip_pulse_test.
#include "afferent/decoders/reflexes.hpp"

#include <gtest/gtest.h>

#include "tests/since_start.hpp"

namespace afferent {
namespace {

constexpr Reflexes::Parameters both{
    .brake = ContactReflex::Parameters{.time_constant = 40ms, .force_limit_n = 26.5, .dead_band = 0.08},
    .pulse = SlipPulse::Parameters{.command = 0.5, .fall_n = 0.1}};

// Calls every millisecond.
struct HandWith {
    Reflexes reflexes;
    TimePoint now = scene_start;

    // The last command.
    double steps(int count, double force_n, double command) {
        double last = 0;
        for (int i = 0; i < count; ++i)
            last = reflexes(now += 1ms, {.force_n = force_n}, true, GripState::operating,
                            {.gain = 1, .command = command});
        return last;
    }
};

TEST(Reflexes, BrakeAtAContactAndCloseAtASlip) {
    HandWith hand{Reflexes(both)};
    EXPECT_EQ(hand.steps(100, 0, 0.4), 0.4);
    EXPECT_EQ(hand.steps(1, 0.3, 0.4), -1);
    EXPECT_EQ(hand.steps(500, 4, 0.03), 0.03);
    EXPECT_EQ(hand.steps(1, 3.8, 0.03), 0.5);
}

TEST(Reflexes, AreThoseThatAreAskedFor) {
    HandWith braking{Reflexes({.brake = both.brake})};
    HandWith closing{Reflexes({.pulse = both.pulse})};
    for (HandWith* const hand : {&braking, &closing}) hand->steps(100, 0, 0.4);
    EXPECT_EQ(braking.steps(1, 0.3, 0.4), -1);
    EXPECT_EQ(closing.steps(1, 0.3, 0.4), 0.4);
    for (HandWith* const hand : {&braking, &closing}) hand->steps(500, 4, 0.03);
    EXPECT_EQ(braking.steps(1, 3.8, 0.03), 0.03);
    EXPECT_EQ(closing.steps(1, 3.8, 0.03), 0.5);
}

TEST(Reflexes, BeginAnewWithARestart) {
    HandWith hand{Reflexes(both)};
    for (int i = 0; i < 2; ++i) {
        hand.steps(100, 0, 0.4);
        EXPECT_EQ(hand.steps(1, 0.3, 0.4), -1) << "no contact is spent any more";
        hand.steps(500, 4, 0.03);
        hand.reflexes.restart();
        EXPECT_EQ(hand.steps(1, 3.8, 0.03), 0.03) << "no force is remembered that it could have fallen from";
        hand.reflexes.restart();
        hand.now = scene_start;
    }
}

}  // namespace
}  // namespace afferent
