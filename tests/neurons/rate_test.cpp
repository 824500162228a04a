// The rates simulated for models without closed forms, against the closed forms of the exact neuron.
#include "afferent/neurons/rate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/refractory.hpp"
#include "afferent/neurons/simulated_rate.hpp"

namespace afferent {
namespace {

constexpr RateKind kinds[] = {RateKind::steady, RateKind::onset};

TEST(SimulatedRate, IsThatOfTheClosedForm) {
    for (const RateKind kind : kinds)
        for (const double delta_g : {0.0, 0.06, 2.0})
            for (const double drive : {15.5, 25.0, 80.0}) {
                const LifParameters parameters{.delta_g = delta_g};
                const double rate = rate_hz(kind, parameters, drive);
                EXPECT_NEAR(simulated_rate_hz(kind, AdaptingLif(parameters), drive), rate, 1e-9 * rate);
            }
}

TEST(SimulatedRate, IsNoneAtRheobaseAndBelow) {
    const AdaptingLif neuron{LifParameters{}};
    for (const RateKind kind : kinds) {
        EXPECT_EQ(simulated_rate_hz(kind, neuron, 15), 0);
        EXPECT_EQ(simulated_rate_hz(kind, neuron, -1e9), 0);
    }
}

TEST(SimulatedRheobase, IsTheHighestDriveWithoutASpike) {
    for (const double v_th_mv : {-64.999, -50.0, 30.0}) {
        const LifParameters parameters{.v_th_mv = v_th_mv};
        EXPECT_EQ(simulated_rheobase_mv(AdaptingLif(parameters)), v_th_mv - -65);
    }
}

TEST(LowestDrive, IsThatOfTheClosedForm) {
    const LifParameters parameters{.delta_g = 0.3, .refractory_ms = 1};
    const Refractory<AdaptingLif> neuron(parameters);
    for (const RateKind kind : kinds)
        for (const double rate : {10.0, 100.0, 400.0}) {
            const double drive = drive_mv(kind, parameters, rate);
            const auto rate_of = [&](double at_mv) { return simulated_rate_hz(kind, neuron, at_mv); };
            EXPECT_NEAR(lowest_drive_mv(rate_of, rate), drive, 1e-6 * drive);
        }
    const auto rate_of = [&](double at_mv) { return simulated_rate_hz(RateKind::onset, neuron, at_mv); };
    EXPECT_TRUE(std::isinf(lowest_drive_mv(rate_of, 1001))) << "beyond the refractory period";
}

TEST(LowestDrive, MayBeBelowAMillivolt) {
    const auto straight = [](double drive_mv) { return 100 * drive_mv; };
    EXPECT_NEAR(lowest_drive_mv(straight, 5), 0.05, 0.05e-6);
}

TEST(LowestDrive, IsTheFootOfAStep) {
    const auto stairs = [](double drive_mv) { return std::max(0.0, std::floor(drive_mv - 15)); };
    EXPECT_NEAR(lowest_drive_mv(stairs, 3), 18, 18e-6);
    EXPECT_NEAR(lowest_drive_mv(stairs, 2.5), 18, 18e-6);
}

// Where the reset lies below E_k, conductance pulls v up: strong adaptation then fires faster than none.
TEST(HighestRate, HoldsAlsoWhereConductancePullsUp) {
    const LifParameters parameters{.v_r_mv = -90, .e_k_mv = -52, .delta_g = 20};
    const double drive = 100;
    EXPECT_GT(rate_hz(RateKind::onset, parameters, drive),
              rate_hz(RateKind::onset, parameters.with_adaptation(0), drive));
    EXPECT_GE(highest_rate_hz(parameters, drive), rate_hz(RateKind::onset, parameters, drive));
    // Without adaptation the interval is tau_m ln(D / (D − rheobase)), and two roundings.
    EXPECT_NEAR(highest_rate_hz(LifParameters{}, drive) * 0.010 * std::log(100.0 / 85), 1, 1e-12);
}

}  // namespace
}  // namespace afferent
