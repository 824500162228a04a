// The states of the pulse at a slip, what bounds it, and what it does to a hand whose object slips.
#include "afferent/decoders/slip_pulse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "afferent/decoders/reflexes.hpp"
#include "afferent/hand/prosthesis_motor.hpp"
#include "afferent/hand/trial_object.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

using State = SlipPulse::State;

constexpr SlipPulse::Parameters at_a_tenth{.command = 0.5,
                                           .pulse = 40ms,
                                           .fall_n = 0.1,
                                           .fall_sigmas = 0,
                                           .within = 100ms,
                                           .settle = 200ms,
                                           .most = 3,
                                           .dead_band = 0.08};

// Calls every millisecond.
struct Hand {
    SlipPulse pulse{at_a_tenth};
    TimePoint now = scene_start;
    double sigma_n = 0;
    double gain = 1;
    Doubt doubt = Doubt::none;
    bool heard = true;

    double step(double force_n, double command = 0, GripState grip = GripState::operating) {
        now += 1ms;
        return pulse(now, {.force_n = force_n, .sigma_n = sigma_n, .doubt = doubt}, heard, grip, gain,
                     command);
    }
    // The last command.
    double steps(int count, double force_n, double command = 0, GripState grip = GripState::operating) {
        double last = 0;
        for (int i = 0; i < count; ++i) last = step(force_n, command, grip);
        return last;
    }
};

TEST(SlipPulse, ClosesForItsTimeWhereTheForceFalls) {
    Hand hand;
    EXPECT_EQ(hand.steps(500, 4, 0.03), 0.03);
    EXPECT_EQ(hand.step(3.91, 0.03), 0.03) << "less than 0.1 N";
    EXPECT_EQ(hand.step(3.89, 0.03), 0.5);
    EXPECT_EQ(hand.pulse.state(), State::pulsing);
    EXPECT_EQ(hand.steps(39, 3.5, 0.03), 0.5) << "40 ms in all";
    EXPECT_EQ(hand.step(3.5, 0.03), 0.03);
    EXPECT_EQ(hand.pulse.state(), State::resting);
}

TEST(SlipPulse, NeverTakesFromAUserWhoClosesHarder) {
    Hand hand;
    hand.steps(300, 4, 0.7);
    EXPECT_EQ(hand.step(3, 0.7), 0.7);
    EXPECT_EQ(hand.pulse.state(), State::pulsing);
}

TEST(SlipPulse, IsHeldBackByTheGain) {
    Hand hand;
    hand.gain = 0.3;
    hand.steps(300, 4);
    EXPECT_DOUBLE_EQ(hand.step(3), 0.15);
    hand.gain = 0;
    EXPECT_EQ(hand.step(3), 0) << "and ends at the limit";
    EXPECT_EQ(hand.pulse.state(), State::resting);
}

// A force that falls from F at r per second falls short of its peak by r·within·(1 − e^(−t/within)).
TEST(SlipPulse, ForgetsThePeakSoThatASlowFallIsNoSlip) {
    const auto begins_after_ms = [](double n_per_s) {
        Hand hand;
        hand.steps(300, 6);
        for (int t = 1; t <= 3000; ++t)
            if (hand.step(6 - n_per_s * t / 1000) != 0) return t;
        return 0;
    };
    EXPECT_EQ(begins_after_ms(0.95), 0) << "0.095 N at most";
    EXPECT_NEAR(begins_after_ms(2), -100 * std::log(1 - 0.1 / (2 * 0.1)), 2);
    EXPECT_NEAR(begins_after_ms(10), -100 * std::log(1 - 0.1 / (10 * 0.1)), 2);
}

TEST(SlipPulse, WaitsUntilTheContactHasSettled) {
    for (int contact = 0; contact < 2; ++contact) {
        Hand hand;
        if (contact == 1) hand.steps(1000, 4);
        hand.steps(110, 0);
        hand.steps(199, 4);
        EXPECT_EQ(hand.step(3), 0) << "the contact is 199 ms old";
        EXPECT_EQ(hand.step(2.5), 0.5);
    }
}

TEST(SlipPulse, WaitsForAFallOfSoManySigmas) {
    Hand hand;
    hand.sigma_n = 0.2;
    SlipPulse::Parameters parameters = at_a_tenth;
    parameters.fall_sigmas = 3;
    hand.pulse = SlipPulse(parameters);
    hand.steps(300, 4);
    EXPECT_EQ(hand.step(3.41), 0);
    EXPECT_EQ(hand.step(3.3), 0.5) << "0.6 N, less what a millisecond forgets";
}

TEST(SlipPulse, RestsBetweenPulsesAndCountsThemInAContact) {
    Hand hand;
    hand.steps(300, 9);
    for (int pulse = 0; pulse < 3; ++pulse) {
        const double force_n = 8 - pulse;
        EXPECT_EQ(hand.step(force_n), 0.5);
        hand.steps(39, force_n);
        EXPECT_EQ(hand.steps(100, force_n - 0.5), 0) << "whatever falls meanwhile";
        hand.step(force_n - 0.5);
        EXPECT_EQ(hand.pulse.state(), State::watching);
    }
    EXPECT_EQ(hand.pulse.pulses(), 3U);
    EXPECT_EQ(hand.step(4), 0) << "three are the most";
    hand.steps(99, 0.09);
    hand.steps(300, 5);
    EXPECT_EQ(hand.step(4), 0) << "no release: it is shorter than 100 ms";
    hand.steps(101, 0.09);
    hand.steps(300, 5);
    EXPECT_EQ(hand.step(4), 0.5) << "another contact";
}

TEST(SlipPulse, DoesNothingToAHandThatOpensUntilItHasComeToRest) {
    Hand hand;
    hand.steps(300, 4);
    for (int t = 0; t < 100; ++t) ASSERT_EQ(hand.step(4 - 0.02 * t, -0.2), -0.2);
    for (int t = 0; t < 99; ++t) ASSERT_EQ(hand.step(2 - 0.01 * t), 0) << "it is still moving";
    hand.steps(50, 1);
    EXPECT_EQ(hand.step(0.8), 0.5);
    EXPECT_EQ(hand.step(0.8, -0.09), -0.09) << "a user who opens ends it";
    Hand within_dead_band;
    within_dead_band.steps(300, 4, -0.08);
    EXPECT_EQ(within_dead_band.step(3, -0.08), 0.5) << "this does not open it";
    Hand told_of_a_wide_one;
    SlipPulse::Parameters wide = at_a_tenth;
    wide.dead_band = 0.5;
    told_of_a_wide_one.pulse = SlipPulse(wide);
    told_of_a_wide_one.steps(300, 4);
    EXPECT_EQ(told_of_a_wide_one.step(3, -0.11), -0.11) << "the user may be opening";
}

TEST(SlipPulse, DoesNothingUnlessTheGripIsOperating) {
    for (const GripState state : {GripState::frozen, GripState::safe}) {
        Hand hand;
        hand.steps(300, 4);
        EXPECT_EQ(hand.step(3, 0, state), 0);
        EXPECT_EQ(hand.step(2, 0), 0) << "nor at once after it";
        Hand pulsing;
        pulsing.steps(300, 4);
        EXPECT_EQ(pulsing.step(3), 0.5);
        EXPECT_EQ(pulsing.step(3, 0, state), 0) << "in the middle of it, too";
        EXPECT_EQ(pulsing.step(3), 0);
    }
}

TEST(SlipPulse, TakesNoDoubtedForceForASlip) {
    for (const Doubt doubt : {Doubt::unheard, Doubt::contradicted, Doubt::unknown, Doubt::saturated}) {
        Hand hand;
        hand.steps(300, 8);
        hand.doubt = doubt;
        EXPECT_EQ(hand.step(4), 0) << name(doubt);
        hand.doubt = Doubt::none;
        EXPECT_EQ(hand.steps(50, 3), 0) << "what fell in doubt has not fallen";
    }
    Hand slow;
    slow.steps(300, 8);
    slow.doubt = Doubt::slow;
    EXPECT_EQ(slow.step(4), 0.5);
}

TEST(SlipPulse, WaitsUntilAFallHasBeenHeard) {
    Hand hand;
    hand.steps(300, 4);
    hand.heard = false;
    EXPECT_EQ(hand.steps(20, 3), 0) << "its packet may have been lost";
    hand.heard = true;
    EXPECT_EQ(hand.step(4), 0) << "and was";
    hand.heard = false;
    hand.steps(20, 5);
    hand.heard = true;
    EXPECT_EQ(hand.step(4), 0) << "nor is a force that was not heard a peak";
    hand.heard = false;
    hand.steps(20, 3);
    hand.heard = true;
    EXPECT_EQ(hand.step(3), 0.5) << "and was not";
}

TEST(SlipPulse, TakesNeitherAnUnknownForceNorALostContactForASlip) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    Hand hand;
    hand.steps(300, 4);
    EXPECT_EQ(hand.steps(20, unknown), 0);
    hand.sigma_n = unknown;
    EXPECT_EQ(hand.step(4), 0);
    Hand lost;
    lost.steps(300, 4);
    EXPECT_EQ(lost.steps(500, 0.09), 0) << "nothing is left to hold";
}

TEST(SlipPulse, BeginsAgainWithASession) {
    Hand hand;
    hand.steps(300, 4);
    hand.step(3);
    hand.pulse.restart();
    EXPECT_EQ(hand.pulse.state(), State::watching);
    EXPECT_EQ(hand.pulse.pulses(), 0U);
    EXPECT_EQ(hand.step(3), 0);
}

// Nothing is known of a force before the first call.
TEST(SlipPulse, TakesTheFirstForceForNoFall) {
    SlipPulse::Parameters at_once = at_a_tenth;
    at_once.settle = 0ms;
    for (const double force_n : {0.3, 0.5, 5.0}) {
        SlipPulse pulse(at_once);
        for (int i = 0; i < 20; ++i)
            EXPECT_EQ(pulse(scene_start + i * 1ms, {.force_n = force_n}, true, GripState::operating, 1, 0),
                      0);
        EXPECT_EQ(pulse(scene_start + 20ms, {.force_n = force_n - 0.11}, true, GripState::operating, 1, 0),
                  0.5);
    }
}

TEST(SlipPulse, HasTheDefaultsOfAScene) {
    EXPECT_EQ(SlipPulse::Parameters(), (SlipPulse::Parameters{.command = 1,
                                                              .pulse = 60ms,
                                                              .fall_n = 0.1,
                                                              .fall_sigmas = 1,
                                                              .within = 100ms,
                                                              .settle = 400ms,
                                                              .most = 5,
                                                              .dead_band = 0}));
}

TEST(SlipPulse, RefusesParametersOutOfTheirRanges) {
    const auto refused = [](auto change) {
        SlipPulse::Parameters parameters = at_a_tenth;
        change(parameters);
        EXPECT_THROW((void)SlipPulse(parameters), ParameterError);
    };
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    for (const double wrong : {0.0, 1.001, unknown}) refused([=](auto& p) { p.command = wrong; });
    refused([](auto& p) { p.pulse = 0ns; });
    for (const double wrong : {0.0, unknown}) refused([=](auto& p) { p.fall_n = wrong; });
    for (const double wrong : {-0.1, unknown}) refused([=](auto& p) { p.fall_sigmas = wrong; });
    refused([](auto& p) { p.within = 0ns; });
    refused([](auto& p) { p.settle = -1ns; });
    refused([](auto& p) { p.most = 0; });
    for (const double wrong : {-0.01, 1.0}) refused([=](auto& p) { p.dead_band = wrong; });
    SlipPulse::Parameters bounds = at_a_tenth;
    bounds.command = 1;
    bounds.most = 1;
    bounds.settle = 0ns;
    bounds.dead_band = 0;
    EXPECT_NO_THROW((void)SlipPulse(bounds));
}

// Whatever comes: no command below the one given, none changed but in a pulse of an operating grip that no
// command opens, none above its strength under the gain, and no more pulses than are allowed.
TEST(SlipPulse, KeepsItsBoundsInARandomWalk) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<> unit(0, 1);
    int pulses = 0;
    for (int walk = 0; walk < 200; ++walk) {
        Hand hand;
        double force_n = 0, command = 0;
        GripState grip = GripState::operating;
        TimePoint began = scene_start;
        for (int i = 0; i < 5000; ++i) {
            if (unit(random) < 0.02) force_n = unit(random) < 0.3 ? 0 : 10 * unit(random);
            if (unit(random) < 0.001) force_n = std::numeric_limits<double>::quiet_NaN();
            if (unit(random) < 0.02) command = 2 * unit(random) - 1;
            if (unit(random) < 0.02) hand.gain = unit(random) < 0.2 ? 0 : unit(random);
            if (unit(random) < 0.01)
                hand.doubt = unit(random) < 0.7 ? Doubt::none : static_cast<Doubt>(1 + walk % 5);
            if (unit(random) < 0.01)
                grip = unit(random) < 0.8 ? GripState::operating
                                          : (unit(random) < 0.5 ? GripState::frozen : GripState::safe);
            const State before = hand.pulse.state();
            const double given = hand.step(force_n, command, grip);
            ASSERT_GE(given, command);
            ASSERT_LE(hand.pulse.pulses(), at_a_tenth.most);
            if (before != State::pulsing && hand.pulse.state() == State::pulsing) {
                ++pulses;
                if (began > scene_start) {
                    ASSERT_GE(hand.now - began, at_a_tenth.within);
                }
                began = hand.now;
            }
            if (given == command) continue;
            ASSERT_EQ(hand.pulse.state(), State::pulsing);
            ASSERT_LT(hand.now - began, at_a_tenth.pulse);
            ASSERT_EQ(grip, GripState::operating);
            ASSERT_LE(hand.doubt, Doubt::slow);
            ASSERT_GE(command, -at_a_tenth.dead_band);
            ASSERT_LE(given, at_a_tenth.command * hand.gain);
        }
    }
    EXPECT_GT(pulses, 100);
}

// An object of 3 N that is held by a little more than it takes while it stands, and lifted within 0.4 s: it
// falls through a hand without a pulse, and is held by one with it, also where motor and object are not as
// the defaults suppose.
TEST(SlipPulse, HoldsAnObjectThatWouldFall) {
    const auto slipped_mm = [](double taper, double speed, bool with_pulse) {
        TrialObject object({.stiffness_n_per_mm = 1.5,
                            .distance_mm = 0,
                            .breaking_force_n = std::nullopt,
                            .weight_n = 3,
                            .friction = 0.4,
                            .taper = taper,
                            .lift_mm_per_s = 60});
        ProsthesisMotor motor({.aperture_mm = 1000, .closing_s = 1000 / (112.5 * speed)});
        for (int i = 0; object.force_n(motor.state().position_mm) < 3; ++i)
            motor.advance(0.13, object.force_n(motor.state().position_mm), 1ms);
        for (int i = 0; i < 500; ++i) motor.advance(0, object.force_n(motor.state().position_mm), 1ms);
        // 3.75 N hold 3 N.
        EXPECT_LT(object.force_n(motor.state().position_mm), 3.75);
        std::optional<Reflexes> reflexes;
        reflexes.emplace(Reflexes::Parameters{.pulse = SlipPulse::Parameters{.fall_n = 0.05}});
        TimePoint now = scene_start;
        for (int i = -500; i < 1500; ++i, now += 1ms) {
            const double force_n = object.force_n(motor.state().position_mm);
            const double command = with_pulse ? (*reflexes)(now, {.force_n = force_n}, true,
                                                            GripState::operating, {.gain = 0.8, .command = 0})
                                              : 0;
            motor.advance(command, force_n, 1ms);
            object.advance(motor.state().position_mm, std::clamp(i / 400.0, 0.0, 1.0), 1ms);
        }
        return object.state().slipped_mm;
    };
    for (const double taper : {0.05, 0.1, 0.3})
        for (const double speed : {0.7, 1.0, 1.3}) {
            SCOPED_TRACE(testing::Message() << taper << ", " << speed);
            EXPECT_GT(slipped_mm(taper, speed, false), 20);
            EXPECT_LT(slipped_mm(taper, speed, true), 10);
        }
}

}  // namespace
}  // namespace afferent
