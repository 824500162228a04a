// The states of the brake, what bounds it, and what it does to a motor.
#include "afferent/decoders/contact_reflex.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "afferent/hand/prosthesis_motor.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "tests/since_start.hpp"

namespace afferent {
namespace {

using State = ContactReflex::State;

constexpr ContactReflex::Parameters of_motor{.time_constant = 40ms, .force_limit_n = 26.5, .dead_band = 0.08};

// Calls every millisecond.
struct Hand {
    ContactReflex reflex{of_motor};
    TimePoint now = scene_start;

    double step(double force_n, double command, GripState grip = GripState::operating) {
        now += 1ms;
        return reflex(now, force_n, grip, command);
    }
    void steps(int count, double force_n, double command, GripState grip = GripState::operating) {
        for (int i = 0; i < count; ++i) step(force_n, command, grip);
    }
};

TEST(ContactReflex, KnowsTheSpeedByTheCommandsThatWereGiven) {
    Hand hand;
    hand.steps(41, 0, 0.5);  // the first command moves the motor from the second call on
    EXPECT_NEAR(hand.reflex.speed(), 0.5 * (1 - std::exp(-1.0)), 1e-12);
    const double before = hand.reflex.speed();
    hand.steps(21, 0, 0.08);
    EXPECT_NEAR(hand.reflex.speed(), (before + (0.5 - before) * (1 - std::exp(-1 / 40.0))) * std::exp(-0.5),
                1e-12)
        << "a command in the dead band is none";
}

TEST(ContactReflex, BrakesUntilTheHandNearlyStands) {
    Hand hand;
    hand.steps(1000, 0, 0.4);
    // From v to v/20 under a command of -1.
    const double takes_ms = 40 * std::log((1 + 0.4) / (1 + 0.4 / 20));
    int braked = 0;
    double last = 0;
    while (hand.reflex.state() != State::spent) {
        last = hand.step(0.5, 0.4);
        braked += last < 0;
        if (hand.reflex.state() == State::braking) {
            EXPECT_EQ(last, -1);
        }
    }
    EXPECT_EQ(braked, std::ceil(takes_ms));
    EXPECT_GT(last, -1) << "only what is left of the speed";
    hand.step(0.5, 0);
    EXPECT_NEAR(hand.reflex.speed(), 0.4 / 20, 1e-12);
}

TEST(ContactReflex, BrakesOnceForEachContact) {
    Hand hand;
    hand.steps(100, 0, 0.4);
    EXPECT_EQ(hand.step(0.3, 0.4), -1) << "at 0.3 N";
    hand.steps(100, 2, 0.4);
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(hand.step(8, 1), 1) << "a user who presses on";
        hand.steps(199, 0.05, 1);
        EXPECT_EQ(hand.step(0.1, 1), 1) << "no release: it is shorter than 200 ms";
    }
    EXPECT_EQ(hand.reflex.state(), State::spent);
    hand.steps(199, 0.05, 0.4);
    EXPECT_EQ(hand.reflex.state(), State::spent);
    hand.step(0.05, 0.4);
    EXPECT_EQ(hand.reflex.state(), State::armed);
    EXPECT_EQ(hand.step(0.29, 0.4), 0.4);
    EXPECT_EQ(hand.step(0.3, 0.4), -1);
}

TEST(ContactReflex, DoesNothingWhereTheHandDoesNotClose) {
    Hand standing;
    EXPECT_EQ(standing.step(0.5, 0), 0);
    EXPECT_EQ(standing.reflex.state(), State::spent);
    EXPECT_EQ(standing.step(0.5, 0.7), 0.7);
    Hand opening;
    opening.steps(50, 0, -0.5);
    EXPECT_EQ(opening.step(0.5, -0.5), -0.5);
    EXPECT_EQ(opening.reflex.state(), State::spent);
}

TEST(ContactReflex, TakesNothingFromAUserWhoOpens) {
    Hand hand;
    hand.steps(100, 0, 0.05 + 0.08);
    hand.step(0.5, 0.1);
    EXPECT_LE(hand.step(0.5, -1), -1);
}

TEST(ContactReflex, DoesNothingUnlessTheGripIsOperating) {
    for (const GripState state : {GripState::frozen, GripState::safe}) {
        Hand hand;
        hand.steps(100, 0, 0.4);
        EXPECT_EQ(hand.step(0.5, 0, state), 0);
        EXPECT_EQ(hand.reflex.state(), State::spent);
        EXPECT_EQ(hand.step(0.5, 0.4), 0.4) << "this contact is spent";
        Hand braking;
        braking.steps(100, 0, 0.4);
        EXPECT_EQ(braking.step(0.5, 0.4), -1);
        EXPECT_EQ(braking.step(0.5, 0, state), 0) << "in the middle of it, too";
        EXPECT_EQ(braking.step(0.5, 0.4), 0.4);
        Hand waiting;
        waiting.steps(100, 0, 0.4);
        waiting.step(0, 0, state);
        EXPECT_EQ(waiting.step(0.5, 0.4), -1) << "a contact that comes after it has its brake";
    }
}

TEST(ContactReflex, TakesNoForceThatIsNotANumberForAContactOrARelease) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    Hand hand;
    hand.steps(100, 0, 0.4);
    EXPECT_EQ(hand.step(unknown, 0.4), 0.4);
    EXPECT_EQ(hand.reflex.state(), State::armed);
    hand.steps(50, 1, 0.4);
    hand.steps(1000, unknown, 0.4);
    EXPECT_EQ(hand.reflex.state(), State::spent);
}

TEST(ContactReflex, EndsWhereItsImpulseDoes) {
    for (const double strength : {1.0, 0.5}) {
        ContactReflex::Parameters parameters = of_motor;
        parameters.command = strength;
        parameters.impulse = 5ms;
        Hand hand{ContactReflex(parameters)};
        hand.steps(1000, 0, 1);
        int braked = 0;
        while (hand.step(0.5, 0) < 0) ++braked;
        EXPECT_EQ(braked, 5 / strength);
        EXPECT_EQ(hand.reflex.state(), State::spent);
    }
}

TEST(ContactReflex, GoesOnWhereTheContactIsLostUntilTheHandNearlyStands) {
    ContactReflex::Parameters weak = of_motor;
    weak.command = 0.05;
    weak.impulse = 1s;
    weak.time_constant = 400ms;
    weak.dead_band = 0;
    Hand hand{ContactReflex(weak)};
    hand.steps(4000, 0, 1);
    hand.step(0.5, 0);
    // From 1 to 0.05: 400 ms · ln(1.05/0.1).
    hand.steps(900, 0, 0);
    EXPECT_EQ(hand.reflex.state(), State::braking);
    hand.steps(50, 0, 0);
    EXPECT_EQ(hand.reflex.state(), State::armed) << "it has long been released";
}

TEST(ContactReflex, BeginsAgainWithASession) {
    Hand hand;
    hand.steps(100, 0, 0.4);
    hand.steps(50, 1, 0.4);
    hand.reflex.restart();
    EXPECT_EQ(hand.reflex.state(), State::armed);
    EXPECT_EQ(hand.reflex.speed(), 0);
}

TEST(ContactReflex, HasTheDefaultsOfAScene) {
    EXPECT_EQ(ContactReflex::Parameters(), (ContactReflex::Parameters{.command = 1,
                                                                      .impulse = 40ms,
                                                                      .contact_n = 0.3,
                                                                      .release_n = 0.1,
                                                                      .release = 200ms,
                                                                      .time_constant = 0ns,
                                                                      .force_limit_n = 0,
                                                                      .dead_band = 0}));
}

TEST(ContactReflex, RefusesParametersThatNoMotorHas) {
    const auto refused = [](auto change) {
        ContactReflex::Parameters parameters = of_motor;
        change(parameters);
        EXPECT_THROW((void)ContactReflex(parameters), ParameterError);
    };
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    for (const double wrong : {0.0, 1.001, unknown}) refused([=](auto& p) { p.command = wrong; });
    refused([](auto& p) { p.impulse = -1ns; });
    for (const double wrong : {-0.1, 0.3, unknown}) refused([=](auto& p) { p.release_n = wrong; });
    refused([](auto& p) { p.contact_n = p.release_n; });
    refused([](auto& p) { p.release = -1ns; });
    refused([](auto& p) { p.time_constant = 0ns; });
    refused([](auto& p) { p.force_limit_n = 0; });
    for (const double wrong : {-0.01, 1.0}) refused([=](auto& p) { p.dead_band = wrong; });
    EXPECT_NO_THROW((void)ContactReflex(of_motor));
    ContactReflex::Parameters bounds = of_motor;
    bounds.release_n = 0;
    bounds.release = bounds.impulse = 0ns;
    bounds.dead_band = 0;
    EXPECT_NO_THROW((void)ContactReflex(bounds));
}

// Whatever comes: no command above the one given, none changed but while it brakes an operating grip, at most
// its impulse in each contact, and a model that does not open by it.
TEST(ContactReflex, KeepsItsBoundsInARandomWalk) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<> unit(0, 1);
    int contacts = 0;
    for (int walk = 0; walk < 200; ++walk) {
        Hand hand;
        double force_n = 0, command = 0, impulse_s = 0;
        GripState grip = GripState::operating;
        TimePoint last_heard = scene_start;
        for (int i = 0; i < 5000; ++i) {
            if (unit(random) < 0.02) force_n = unit(random) < 0.5 ? 0 : 10 * std::pow(unit(random), 3);
            if (unit(random) < 0.001) force_n = std::numeric_limits<double>::quiet_NaN();
            if (unit(random) < 0.02) command = 2 * unit(random) - 1;
            if (unit(random) < 0.01)
                grip = unit(random) < 0.8 ? GripState::operating
                                          : (unit(random) < 0.5 ? GripState::frozen : GripState::safe);
            const State before = hand.reflex.state();
            const double given = hand.step(force_n, command, grip);
            ASSERT_LE(given, command);
            if (force_n >= of_motor.release_n) last_heard = hand.now;
            if (before == State::armed && hand.reflex.state() != State::armed) {
                ++contacts;
                impulse_s = 0;
            }
            if (before == State::spent && hand.reflex.state() == State::armed) {
                ASSERT_GE(hand.now - last_heard, of_motor.release);
            }
            if (given == command) continue;
            ASSERT_EQ(grip, GripState::operating);
            ASSERT_NE(before, State::spent);
            ASSERT_GE(given, -of_motor.command);
            ASSERT_GT(hand.reflex.speed(), 0) << "the hand closes";
            impulse_s -= given * 1e-3;
            ASSERT_LE(impulse_s, seconds(of_motor.impulse) + 1e-9);
        }
    }
    EXPECT_GT(contacts, 1000);
}

// A hand that approaches at three speeds stands within the way that the delay of the contact and the brake
// take, whatever the load, and opens by less than a millimetre where the motor's constants are not as told.
TEST(ContactReflex, StopsAMotorThatIsNotQuiteAsItWasTold) {
    for (const double approach : {0.2, 0.5, 1.0})
        for (const double speed : {0.7, 1.0, 1.3})
            for (const double lag : {0.7, 1.0, 1.3}) {
                SCOPED_TRACE(testing::Message() << approach << ", " << speed << ", " << lag);
                ProsthesisMotor motor(
                    {.aperture_mm = 1000, .closing_s = 1000 / (112.5 * speed), .time_constant_ms = 40 * lag});
                Hand hand;
                double command = 0, deepest_mm = 0;
                for (int i = 0; i < 2000; ++i) {
                    const double touch_mm = 20;
                    const double depth_mm = motor.state().position_mm - touch_mm;
                    const double force_n = std::max(0.0, 2.76 * depth_mm);
                    command = hand.step(force_n, hand.reflex.state() == State::armed ? approach : 0);
                    motor.advance(command, force_n, 1ms);
                    deepest_mm = std::max(deepest_mm, motor.state().position_mm - touch_mm);
                }
                ASSERT_EQ(hand.reflex.state(), State::spent);
                const double opened_mm = deepest_mm - (motor.state().position_mm - 20);
                EXPECT_LT(opened_mm, 1);
                // Without a brake the speed that is left carries the fingers on by v tau.
                EXPECT_LT(deepest_mm, 0.6 * approach * 112.5 * speed * 0.040 * lag);
            }
}

}  // namespace
}  // namespace afferent
