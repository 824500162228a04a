// What a trial simulates: electrodes, motor, objects and the user.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "afferent/hand/prosthesis_motor.hpp"
#include "afferent/hand/surface_emg.hpp"
#include "afferent/hand/trial_object.hpp"
#include "afferent/hand/trial_user.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double emg_rate_hz = 1000;

struct Moments {
    double mean;
    double variation;  // standard deviation over mean
};

// Mean and deviation of the rectified EMG over windows of that many samples, as a part of full scale.
Moments amplitude(double effort, std::size_t window, std::size_t windows) {
    SurfaceEmg emg({}, emg_rate_hz, 5, Stream::closing_emg);
    double sum = 0;
    double squares = 0;
    for (std::size_t i = 0; i < windows; ++i) {
        double rectified = 0;
        for (std::size_t k = 0; k < window; ++k)
            rectified += std::abs(emg.counts(effort) - User::rest_counts) / User::full_scale_counts;
        const double mean = rectified / static_cast<double>(window);
        sum += mean;
        squares += mean * mean;
    }
    const double mean = sum / static_cast<double>(windows);
    return {mean, std::sqrt(squares / static_cast<double>(windows) / (mean * mean) - 1)};
}

// The same from the process: its autocorrelation, and the covariance of the absolute values of two normal
// numbers with correlation r, 2/π (√(1 − r²) + r asin r − 1).
double expected_variation(std::size_t window) {
    const SurfaceEmg::Parameters emg;
    const double radius = std::exp(-std::numbers::pi * emg.bandwidth_hz / emg_rate_hz);
    const double a1 = 2 * radius * std::cos(2 * std::numbers::pi * emg.centre_hz / emg_rate_hz);
    const double a2 = -radius * radius;
    std::vector<double> correlation{1, a1 / (1 - a2)};
    while (correlation.size() < window)
        correlation.push_back(a1 * correlation.back() + a2 * correlation[correlation.size() - 2]);
    const double n = static_cast<double>(window);
    double variance = 0;
    for (std::size_t k = 0; k < window; ++k) {
        const double r = correlation[k];
        const double covariance = 2 / std::numbers::pi * (std::sqrt(1 - r * r) + r * std::asin(r) - 1);
        variance += (k == 0 ? n : 2 * (n - static_cast<double>(k))) * covariance / (n * n);
    }
    return std::sqrt(variance / (2 / std::numbers::pi));
}

TEST(SurfaceEmg, HasTheVariationOfSurfaceElectrodesAtAnyContraction) {
    EXPECT_GE(expected_variation(60), 0.16);
    EXPECT_LE(expected_variation(60), 0.20);
    EXPECT_NEAR(expected_variation(200), 0.085, 0.005);  // published figures differ by more
    // The deviation of a deviation from n windows is about 1/√(2n) of it; five of those. Windows are nearly
    // independent, since the process forgets within a few samples.
    constexpr std::size_t windows = 2500;
    const double tolerance = 5 / std::sqrt(2.0 * windows);
    for (const double effort : {0.1, 0.3, 0.8})
        for (const std::size_t window : {60, 200}) {
            // Clipping at the ends of the converter takes 0.1 % of the mean at an effort of 0.8.
            const Moments measured = amplitude(effort, window, windows);
            EXPECT_NEAR(measured.variation / expected_variation(window), 1, tolerance)
                << effort << " " << window;
            EXPECT_NEAR(measured.mean / std::hypot(effort, 0.05), 1,
                        5 * expected_variation(window) / std::sqrt(1.0 * windows) + 0.001);
        }
    EXPECT_NEAR(amplitude(0, 60, windows).mean, 0.05,
                0.001);  // the same for 0.16/√2500, and rounding to counts
}

TEST(SurfaceEmg, IsTheSameForTheSameRecording) {
    SurfaceEmg emg({}, emg_rate_hz, 1, Stream::closing_emg);
    std::vector<double> counts;
    emg.begin(3);
    for (int i = 0; i < 20; ++i) counts.push_back(emg.counts(0.4));
    emg.begin(4);
    EXPECT_NE(emg.counts(0.4), counts[0]);
    emg.begin(3);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(emg.counts(0.4), counts[static_cast<std::size_t>(i)]);
}

TEST(SurfaceEmg, RefusesASpectrumBeyondItsSamples) {
    EXPECT_THROW(SurfaceEmg({.centre_hz = 500}, 1000, 1, Stream::closing_emg), ParameterError);
    EXPECT_THROW(SurfaceEmg({.bandwidth_hz = 0}, 1000, 1, Stream::closing_emg), ParameterError);
    EXPECT_THROW(SurfaceEmg({.rest_effort = 1.1}, 1000, 1, Stream::closing_emg), ParameterError);
}

TEST(ProsthesisMotor, ClosesInItsTimeAtFullCommandAndSlowerAtLess) {
    for (const double command : {1.0, 0.4}) {
        ProsthesisMotor motor({.aperture_mm = 90, .closing_s = 0.8, .time_constant_ms = 40});
        // After the lag x = command · 90 mm/0.8 s · (t − 40 ms); e^(−0.6/0.04) is nothing.
        motor.advance(command, 0, 600ms);
        EXPECT_NEAR(motor.state().position_mm, command * 90 / 0.8 * 0.56, 1e-4);
    }
    ProsthesisMotor motor({});
    motor.advance(1, 0, 2s);
    EXPECT_EQ(motor.state().position_mm, 90);
}

TEST(ProsthesisMotor, MovesAlikeInPiecesAndAtOnce) {
    ProsthesisMotor at_once({});
    ProsthesisMotor in_pieces({});
    at_once.advance(0.5, 3, 100ms);
    for (int i = 0; i < 100; ++i) in_pieces.advance(0.5, 3, 1ms);
    EXPECT_NEAR(in_pieces.state().position_mm, at_once.state().position_mm, 1e-9);
}

// Against a spring of 1 N/mm.
TEST(ProsthesisMotor, EndsAtTheForceOfItsCommandAndStaysThereWithoutOne) {
    ProsthesisMotor motor({.force_limit_n = 20});
    const auto run = [&](double command, int steps) {
        for (int i = 0; i < steps; ++i) motor.advance(command, motor.state().position_mm, 1ms);
        return motor.state().position_mm;
    };
    // The motor and the spring are overdamped, 40 ms against 20 N/(1 N/mm · 112.5 mm/s) = 178 ms, by a factor
    // of 4.4: it does not pass its force by more than what a millisecond adds.
    EXPECT_NEAR(run(0.5, 3000), 10, 0.01);
    EXPECT_NEAR(run(0, 1000), 10, 0.01);
    EXPECT_NEAR(run(0.08, 1000), 10, 0.01) << "within the dead band";
    EXPECT_NEAR(run(0.3, 1000), 10, 0.01) << "the force does not drive it back";
    EXPECT_NEAR(run(std::nan(""), 1000), 10, 0.01);
    EXPECT_LT(run(-0.2, 200), 9) << "the user may open";
    EXPECT_EQ(run(-1, 2000), 0);
}

TEST(ProsthesisMotor, RefusesWhatCannotBe) {
    EXPECT_THROW(ProsthesisMotor({.aperture_mm = 0}), ParameterError);
    EXPECT_THROW(ProsthesisMotor({.closing_s = 0}), ParameterError);
    EXPECT_THROW(ProsthesisMotor({.force_limit_n = -1}), ParameterError);
    EXPECT_THROW(ProsthesisMotor({.time_constant_ms = 0}), ParameterError);
    EXPECT_THROW(ProsthesisMotor({.dead_band = 1}), ParameterError);
}

TEST(TrialObject, BreaksAboveItsBreakingForce) {
    TrialObject object({.stiffness_n_per_mm = 2, .distance_mm = 30, .breaking_force_n = 8});
    EXPECT_EQ(object.force_n(29), 0);
    EXPECT_DOUBLE_EQ(object.force_n(34), 8);
    object.advance(34, 0, 1ms);
    EXPECT_FALSE(object.state().broken);
    object.advance(34.001, 0, 1ms);
    EXPECT_TRUE(object.state().broken);

    TrialObject tough({.stiffness_n_per_mm = 2, .distance_mm = 30});
    tough.advance(90, 0, 1ms);
    EXPECT_FALSE(tough.state().broken);
}

TEST(TrialObject, SlipsWhereFrictionDoesNotCarryItsLoad) {
    // 2 · 0.5 · F = 4 N at 4 mm.
    const TrialObject::Parameters heavy{
        .stiffness_n_per_mm = 1, .distance_mm = 0, .weight_n = 4, .friction = 0.5, .lift_mm_per_s = 1000};
    TrialObject held(heavy);
    held.advance(4, 1, 1ms);
    EXPECT_FALSE(held.state().slips());
    TrialObject half_lifted(heavy);
    half_lifted.advance(2, 0.5, 1ms);
    EXPECT_FALSE(half_lifted.state().slips());

    TrialObject slips(heavy);
    slips.advance(3, 1, 1ms);
    EXPECT_TRUE(slips.state().slips());
    // A firmer grip stops it: g (4 − 6)/4 takes 10 ms for the 49 mm/s that 20 ms at g (4 − 3)/4 have given.
    for (int i = 1; i < 20; ++i) slips.advance(3, 1, 1ms);
    EXPECT_NEAR(slips.state().slip_mm_per_s, 9806.65 / 4 * 0.02, 1e-6);
    for (int i = 0; i < 11; ++i) slips.advance(6, 1, 1ms);
    EXPECT_FALSE(slips.state().slips());
}

TEST(TrialObject, FallsOutOfAnOpenHand) {
    TrialObject object({.stiffness_n_per_mm = 1, .distance_mm = 0, .weight_n = 1});
    object.advance(10, 1, 1ms);
    for (int i = 0; i < 100; ++i) object.advance(0, 1, 1ms);
    // g t²/2; a step of h adds g t h/2.
    EXPECT_NEAR(object.state().slipped_mm, 9806.65 * 0.1 * 0.1 / 2, 9806.65 * 0.1 * 0.001 / 2 + 1e-9);
}

TEST(TrialObject, StaysOnTheTableUntilItIsCarried) {
    TrialObject object({.distance_mm = 30, .weight_n = 1, .lift_mm_per_s = 50});
    for (int i = 0; i < 1000; ++i) object.advance(0, 1, 1ms);
    EXPECT_EQ(object.state().slip_mm_per_s, 50);
    // At g the hand's speed is reached within 6 ms.
    EXPECT_NEAR(object.state().slipped_mm, 50, 0.3);
}

TEST(TrialObject, LosesForceWhereItNarrows) {
    TrialObject object({.stiffness_n_per_mm = 1,
                        .distance_mm = 0,
                        .weight_n = 4,
                        .friction = 0.5,
                        .taper = 0.1,
                        .lift_mm_per_s = 1000});
    for (int i = 0; i < 50; ++i) object.advance(3, 1, 1ms);
    // s'' = g/4 N · (4 N − 2 · 0.5 · (3 N − 0.1 N/mm · s)) from rest: 10 mm (cosh ωt − 1), ω² = g · 0.1/mm
    // / 4. A step of a millisecond adds half of what it slips in one.
    const double omega = std::sqrt(9806.65 * 0.1 / 4);
    EXPECT_NEAR(object.state().slipped_mm, 10 * (std::cosh(0.05 * omega) - 1), 0.1);
    EXPECT_DOUBLE_EQ(object.force_n(3), 3 - 0.1 * object.state().slipped_mm);
}

double below(double z) { return std::erfc(-z / std::numbers::sqrt2) / 2; }

TEST(TrialObjects, BreakAboveTheLeastForceWithTheirSpread) {
    const TrialObjects objects;
    const TrialObjects::Delicate& delicate = objects.delicate;
    constexpr std::uint32_t count = 20'000;
    double least_n = 1e9;
    double slippery = 0;
    double breakable = 0;
    double under_median = 0;
    double under_one_more = 0;
    for (std::uint32_t number = 0; number < count; ++number) {
        const TrialObject::Parameters object = objects.object(1, number);
        EXPECT_EQ(object.breaking_force_n.has_value(), !objects.is_slippery(1, number));
        if (!object.breaking_force_n) {
            ++slippery;
            continue;
        }
        ++breakable;
        least_n = std::min(least_n, *object.breaking_force_n);
        if (*object.breaking_force_n < delicate.breaking_force_n) ++under_median;
        if (*object.breaking_force_n < delicate.breaking_force_n * std::exp(delicate.breaking_spread))
            ++under_one_more;
    }
    EXPECT_GE(least_n, delicate.least_breaking_force_n);
    // Each is a count of one in two or so: five of its deviations are at most 2.5/√n.
    const double tolerance = 2.5 / std::sqrt(breakable);
    EXPECT_NEAR(slippery / count, objects.slippery.part, 2.5 / std::sqrt(count));
    const double cut = below(std::log(delicate.least_breaking_force_n / delicate.breaking_force_n) /
                             delicate.breaking_spread);
    EXPECT_NEAR(under_median / breakable, (0.5 - cut) / (1 - cut), tolerance);
    EXPECT_NEAR(under_one_more / breakable, (below(1) - cut) / (1 - cut), tolerance);
}

TEST(TrialObjects, RefuseWhatCannotBe) {
    EXPECT_THROW(TrialObjects({.delicate = {.breaking_force_n = 8}}).check(), ParameterError);
    EXPECT_THROW(TrialObjects({.delicate = {.stiffness_spread = -1}}).check(), ParameterError);
    EXPECT_THROW(TrialObjects({.slippery = {.part = 2}}).check(), ParameterError);
    EXPECT_THROW(TrialObjects({.slippery = {.weight_n = 0}}).check(), ParameterError);
    EXPECT_NO_THROW(TrialObjects().check());
}

TEST(TrialUser, SeesContactAndSlipOnlyAfterAReactionTime) {
    const TrialUser user(
        {.begin_s = 0.2, .delay_ms = 50, .grip_s = 0.6, .lift_s = 0.4, .hold_s = 0.7, .slip_effort = 1.5},
        26.5, 1);
    const TrialUser::Intent intent{
        .aimed_force_n = 5.3, .reach_effort = 0.3, .grip_effort = 0.2, .reaction_s = 0.25};
    EXPECT_EQ(user.aimed_effort(intent, 0.24, {}), 0);
    EXPECT_EQ(user.aimed_effort(intent, 0.26, {}), 0.3);
    const TrialUser::Seen contact{.contact_s = 1, .slip_s = {}};
    EXPECT_EQ(user.aimed_effort(intent, 1.29, contact), 0.3);
    EXPECT_EQ(user.aimed_effort(intent, 1.31, contact), 0.2);
    EXPECT_EQ(user.lifted(intent, 1.85, contact), 0);
    EXPECT_NEAR(user.lifted(intent, 2.05, contact), 0.5, 1e-12);
    EXPECT_EQ(user.lifted(intent, 2.3, contact), 1);
    // 1 + 0.25 + 0.6 + 0.4 s, 0.2 s to settle, and the delay.
    EXPECT_EQ(user.aimed_effort(intent, 2.49, contact), 0.2);
    EXPECT_EQ(user.aimed_effort(intent, 2.51, contact), 0);
    const TrialUser::Seen slip{.contact_s = 1, .slip_s = 2};
    EXPECT_EQ(user.aimed_effort(intent, 2.29, slip), 0.2);
    EXPECT_DOUBLE_EQ(user.aimed_effort(intent, 2.31, slip), 0.3);
    EXPECT_NEAR(user.end_s(intent, contact), 2.45 + 0.7, 1e-12);
}

TEST(TrialUser, PressesOnWhereTheHandFeelsWeak) {
    const TrialUser user({.begin_s = 0.2, .delay_ms = 50, .slip_effort = 1.5, .press_on = 2}, 26.5, 1);
    const TrialUser::Intent intent{
        .aimed_force_n = 5.3, .reach_effort = 0.3, .grip_effort = 0.2, .reaction_s = 0.25};
    const auto effort = [&](double time_s, double weakness, std::optional<double> slip_s = {}) {
        return user.aimed_effort(intent, time_s, {.contact_s = 1, .slip_s = slip_s, .weakness = weakness});
    };
    EXPECT_EQ(effort(1.4, 0), 0.2);
    EXPECT_DOUBLE_EQ(effort(1.4, 0.25), 0.2 * 1.5);
    EXPECT_EQ(effort(1.2, 0.25), 0.3) << "it is the effort of the grip, and not of the reach";
    EXPECT_DOUBLE_EQ(effort(1.8, 0.25, 1.4), 1.5 * 0.2 * 1.5);
    EXPECT_EQ(TrialUser({.press_on = 50}, 26.5, 1)
                  .aimed_effort(intent, 1.4, {.contact_s = 1, .slip_s = {}, .weakness = 1}),
              1);
    EXPECT_THROW(TrialUser({.press_on = -0.1}, 26.5, 1), ParameterError);
}

TEST(TrialUser, AimsWithTheSpreadOfPresentationsAndOfUsers) {
    const TrialUser user({.users = 1000, .aim_n = 7, .aim_spread = 0.3, .user_spread = 0.4}, 26.5, 1);
    constexpr std::uint32_t count = 20'000;
    double sum = 0;
    double squares = 0;
    for (std::uint32_t number = 0; number < count; ++number) {
        const double log_aim = std::log(user.intent(number).aimed_force_n / 7);
        sum += log_aim;
        squares += log_aim * log_aim;
    }
    // Five deviations, which the thousand users decide: 0.4/√1000, and 1/√(2 · 1000) of a deviation.
    EXPECT_NEAR(sum / count, 0, 5 * 0.4 / std::sqrt(1000.0));
    EXPECT_NEAR(std::sqrt(squares / count), 0.5, 5 * 0.5 / std::sqrt(2000.0));
    EXPECT_DOUBLE_EQ(user.intent(5, 2).aimed_force_n, 2 * user.intent(5).aimed_force_n);
    EXPECT_EQ(user.intent(5).grip_effort, user.intent(5).aimed_force_n / 26.5);
}

TEST(TrialUser, RefusesWhatCannotBe) {
    EXPECT_THROW(TrialUser({.users = 0}, 26.5, 1), ParameterError);
    EXPECT_THROW(TrialUser({.reach_effort = 1.1}, 26.5, 1), ParameterError);
    EXPECT_THROW(TrialUser({.aim_n = 0}, 26.5, 1), ParameterError);
    EXPECT_THROW(TrialUser({.reaction_ms = -1}, 26.5, 1), ParameterError);
    EXPECT_THROW(TrialUser({.slip_effort = 0.5}, 26.5, 1), ParameterError);
}

}  // namespace
}  // namespace afferent
