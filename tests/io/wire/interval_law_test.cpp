#include "afferent/io/wire/interval_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "afferent/io/wire/spike_chances.hpp"

namespace afferent {
namespace {

constexpr double drive_units = 1 << 24;
constexpr double g_units = 1 << 16;

// The drive over E_k, in units of v_th − E_k, by another method: the membrane in small steps of Runge and
// Kutta, once with the drive and once without, since it is linear in it.
double stepped_drive(const NeuronLaw& law, double interval_ms, double g) {
    const double threshold = law.v_th_mv - law.e_k_mv;
    const int steps = 20'000;
    const double h = interval_ms / steps;
    const auto at_threshold = [&](double w, double b) {
        const auto slope = [&](double time_ms, double value) {
            return (b - (1 + g * std::exp(-time_ms / law.tau_g_ms)) * value) / law.tau_m_ms;
        };
        for (int step = 0; step < steps; ++step) {
            const double t = step * h;
            const double first = slope(t, w);
            const double second = slope(t + h / 2, w + h / 2 * first);
            const double third = slope(t + h / 2, w + h / 2 * second);
            const double fourth = slope(t + h, w + h * third);
            w += h / 6 * (first + 2 * second + 2 * third + fourth);
        }
        return w;
    };
    const double phi = at_threshold(1, 0);
    const double psi = at_threshold(0, 1);
    return (1 - (law.v_r_mv - law.e_k_mv) / threshold * phi) / psi;
}

TEST(IntervalLaw, IsTheNeuronsOwn) {
    for (const NeuronLaw& law : {NeuronLaw{}, NeuronLaw{.tau_g_ms = 500, .delta_g = 0.03},
                                 NeuronLaw{.tau_m_ms = 30, .tau_g_ms = 20, .delta_g = 2},
                                 NeuronLaw{.v_r_mv = -72, .e_k_mv = -60, .delta_g = 0}})
        for (const Duration tick : {Duration(10us), Duration(100us), Duration(1ms)}) {
            const IntervalLaw table(law, tick);
            for (const double interval_ms : {3.0, 8.1, 20.5, 47.0}) {
                const double g = law.delta_g * 3.3;
                const auto interval =
                    static_cast<std::uint32_t>(interval_ms * 16e6 / static_cast<double>(tick.count()));
                const auto g_code = static_cast<std::uint32_t>(g * g_units);
                const double expected = stepped_drive(law, interval_ms, g);
                SCOPED_TRACE(interval_ms);
                EXPECT_NEAR(table.drive(interval, g_code) / drive_units, expected, 1e-2 * expected);
                const auto drive = static_cast<std::uint32_t>(expected * drive_units);
                EXPECT_NEAR(table.interval(drive, g_code), interval, 2e-2 * interval);
            }
        }
}

TEST(IntervalLaw, GivesTheIntervalOfADriveThatIsHeldBack) {
    for (const NeuronLaw& law :
         {NeuronLaw{}, NeuronLaw{.delta_g = 0}, NeuronLaw{.tau_m_ms = 1e-3, .tau_g_ms = 1e5},
          NeuronLaw{.tau_m_ms = 1e3, .tau_g_ms = 0.01, .delta_g = 1e4}, NeuronLaw{.refractory_ms = 2}}) {
        const IntervalLaw table(law, 100us);
        for (std::uint32_t interval = 40 * 16 + 3; interval < 16 * 600; interval += 77)
            for (const std::uint32_t jumps : {1U, 2U, 7U}) {
                const std::uint32_t g = table.first_adaptation() * jumps;
                const std::uint32_t drive = table.drive(interval, g);
                // Not where all drives that are left are the same number, or the largest.
                if (table.drive(interval - 16, g) - table.drive(interval + 16, g) < 200) continue;
                EXPECT_NEAR(table.interval(drive, g), interval, 1 + interval / 400.0) << law.tau_m_ms;
                for (const std::uint32_t near : {1U, interval, 4 * interval, 0xffff'ffffU})
                    EXPECT_EQ(table.interval(drive, g, near), table.interval(drive, g)) << near;
            }
    }
}

TEST(IntervalLaw, ForeseesNothingWhereTheDriveIsTooWeak) {
    const IntervalLaw table({}, 100us);
    EXPECT_EQ(table.interval(0, 0), 0U);
    EXPECT_EQ(table.interval(static_cast<std::uint32_t>(0.99 * drive_units), table.first_adaptation()), 0U);
    EXPECT_GT(table.interval(static_cast<std::uint32_t>(1.2 * drive_units), table.first_adaptation()), 0U);
    EXPECT_EQ(table.interval(0xffff'ffff, 0), 16U) << "a tick is the shortest";
    const IntervalLaw refractory({.refractory_ms = 2}, 100us);
    EXPECT_EQ(refractory.interval(0xffff'ffff, 0), 21U * 16);
}

TEST(IntervalLaw, LetsAdaptationDecayAndJump) {
    const IntervalLaw table({.tau_g_ms = 50, .delta_g = 0.5}, 100us);
    EXPECT_EQ(table.first_adaptation(), 1U << 15);
    for (const std::uint32_t ticks : {0U, 1U, 63U, 64U, 500U, 4095U, 4096U, 20'000U, 262'143U, 1'000'000U}) {
        const double expected = 4 * std::exp(static_cast<double>(ticks) * -0.1 / 50) + 0.5;
        EXPECT_NEAR(table.next_adaptation(4 << 16, ticks) / g_units, expected, 1e-4) << ticks;
    }
    // That of a neuron that fires at each tick is the largest.
    std::uint32_t g = 0;
    for (int spike = 0; spike < 100'000; ++spike) g = table.next_adaptation(g, 1);
    EXPECT_NEAR(g / g_units, 0.5 / (1 - std::exp(-0.002)), 0.1);
    EXPECT_EQ(table.next_adaptation(0xffff'ffff, 1), table.next_adaptation(0xffff'fffe, 1));
}

TEST(SpikeChances, AreStudentsDistribution) {
    for (const std::uint32_t spread : {1U, 2U, 4U, 8U, 40U, 1024U, 0xffffU}) {
        std::uint32_t before = 0;
        for (double z = -120; z < 120; z += 0.37) {
            const auto distance = static_cast<std::int64_t>(std::lround(z * 2 * spread));
            const double exact = static_cast<double>(distance) / (2.0 * spread);
            const std::uint32_t chance = SpikeChances(spread).until(distance);
            // The spread is rounded down to a quarter of an octave.
            const double low = exact < 0 ? exact * 1.25 : exact;
            const double high = exact < 0 ? exact : exact * 1.25;
            const auto student = [](double at) { return (1 + at / std::sqrt(2 + at * at)) / 2; };
            EXPECT_GE(chance, student(low) * SpikeChances::scale - 60) << z << " of " << spread;
            EXPECT_LE(chance, student(high) * SpikeChances::scale + 60) << z << " of " << spread;
            EXPECT_GE(chance, before);
            before = chance;
        }
    }
    EXPECT_EQ(SpikeChances(5).until(0), SpikeChances::scale / 2);
    for (const std::int64_t distance : {1, 7, 100, 100'000})
        EXPECT_EQ(SpikeChances(5).until(distance) + SpikeChances(5).until(-distance), SpikeChances::scale);
}

TEST(SpikeChances, FollowMissesAndForgiveAWildOne) {
    std::uint32_t spread = 1000;
    for (int spike = 0; spike < 100; ++spike) spread = SpikeChances::after(spread, 40);
    EXPECT_NEAR(spread, 20, 3) << "misses are in sixteenths of a tick, spreads in eighths";
    EXPECT_EQ(SpikeChances::after(spread, 1'000'000), spread + (4 * spread + 64 - spread) / 4);
    for (int spike = 0; spike < 100; ++spike) spread = SpikeChances::after(spread, 0);
    EXPECT_EQ(spread, 1U);
    for (int spike = 0; spike < 100; ++spike) spread = SpikeChances::after(spread, 0xffff'ffff);
    EXPECT_EQ(spread, SpikeChances::most_spread);
}

}  // namespace
}  // namespace afferent
