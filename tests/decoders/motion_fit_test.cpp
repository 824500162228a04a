#include "afferent/decoders/motion_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/long_runs.hpp"

namespace afferent {
namespace {

// A force whose speed is an Ornstein–Uhlenbeck process of that standard deviation, with a time constant of a
// second, around 20 N.
ForceTrace wandering(double speed_n_per_s, unsigned seed, int points = 4000) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    ForceTrace force;
    double force_n = 20;
    double speed = 0;
    const double kept = std::exp(-0.005);
    for (int i = 0; i < points; ++i) {
        force.push_back({0.005 * i, force_n});
        force_n += 0.005 * speed - 0.002 * (force_n - 20);
        speed = kept * speed + speed_n_per_s * std::sqrt(1 - kept * kept) * normal(random);
    }
    return force;
}

// Different parameters may fit equally well, so the test is how well they predict.
TEST(MotionFit, ForetellsAForceAsWellAsWhoKnewHowItMoves) {
    for (const double speed_n_per_s : {6.0, 30.0, 120.0}) {
        if (!long_runs && speed_n_per_s != 30) continue;
        const ForceTrace force = wandering(speed_n_per_s, 1);
        const MotionFit fit = fit_motions(force, 1e-3);
        ForceBelief::Parameters known;
        known.motion[1].speed_n_per_s = speed_n_per_s;
        EXPECT_GT(fit.score, fit.score_before);
        EXPECT_GT(fit.score, fit_motions(force, 1e-3, known).score_before - 0.01);
    }
}

// What moves is assumed to be far faster than this force, and what is at rest far stiller.
TEST(MotionFit, TakesEachStrengthNoFurtherThanThirtyTimesFromWhereItBegan) {
    ForceBelief::Parameters begun;
    begun.motion[0].speed_n_per_s = 0.04;
    begun.motion[0].drift_n2_per_s = 4e-5;
    begun.motion[1].speed_n_per_s = 60;
    begun.motion[2].speed_n_per_s = 70'000;
    const auto fitted = fit_motions(wandering(0.3, 1, 1000), 1e-3, begun).force.motion;
    // The search ends within 2^-12 of the range of the logarithm, which is 6.8.
    EXPECT_NEAR(std::log(fitted[0].speed_n_per_s / 0.04), std::log(30), 0.01);
    EXPECT_NEAR(std::log(fitted[0].drift_n2_per_s / 4e-5), std::log(30), 0.01);
    EXPECT_NEAR(std::log(fitted[1].speed_n_per_s / 60), -std::log(30), 0.01);
    EXPECT_NEAR(std::log(fitted[2].speed_n_per_s / 70'000), -std::log(30), 0.01);
}

TEST(MotionFit, LeavesTheBeliefHonest) {
    const MotionFit fit = fit_motions(wandering(20, 2), 0.01);
    ASSERT_GT(fit.foretold.size(), 10U);
    EXPECT_TRUE(std::ranges::is_sorted(fit.foretold, {}, &MotionFit::Foretold::sigma_n));
    double sigma_n2 = 0;
    double error_n2 = 0;
    for (const auto& [foretold_n, error_n] : fit.foretold) {
        sigma_n2 += foretold_n * foretold_n;
        error_n2 += error_n * error_n;
    }
    // The predicted error is never too small, and not much too large: only some of the strengths are fitted.
    EXPECT_LT(std::sqrt(error_n2 / sigma_n2), 1.1);
    EXPECT_GT(std::sqrt(error_n2 / sigma_n2), 0.4);
}

TEST(MotionFit, TakesAForceThatIsAlwaysZero) {
    const MotionFit fit = fit_motions({{0, 0}, {0.01, 0}, {0.02, 0}, {0.05, 0}}, 0.01);
    EXPECT_TRUE(std::isfinite(fit.score));
    EXPECT_GE(fit.score, fit.score_before);
}

}  // namespace
}  // namespace afferent
