#include "afferent/hand/indenter_wave.hpp"

#include <gtest/gtest.h>

namespace afferent {
namespace {

constexpr ElasticSkin half_space{.modulus_kpa = 50, .poisson = 0.4};
constexpr double wave_pitch_mm = 2;
constexpr Position at_mm(double x_mm, double y_mm = 0) { return {x_mm, y_mm}; }

TimePoint at(double s) { return scene_start + from_seconds(s); }

// An element of a grid of 2 mm, 20 mm away from a punch of 1 mm radius with 0.3 N, at a depth of 3 mm:
// 3 · 0.3/(2π 9) · 2/π arcsin(1/20) · 4 N.
constexpr double force_20_mm_away_n = 0.9 / 56.548667764616276 * 0.03184426 * 4;

TEST(IndenterWave, IsThePressureOfAPointLoadLessByTheDeflectionOutsideAPunch) {
    const IndenterWave wave({.x_mm = 5, .tip = IndenterTip::flat, .radius_mm = 1, .force_n = 0.3}, half_space,
                            {.speed_m_per_s = 8, .depth_mm = 3, .reach_mm = 60}, Aperture(wave_pitch_mm));
    const auto pressure = wave.at(at(10));
    EXPECT_NEAR(pressure.force_n(at_mm(25)), force_20_mm_away_n, 1e-6 * force_20_mm_away_n);
    EXPECT_NEAR(pressure.force_n(at_mm(5 + 12, 16)), force_20_mm_away_n, 1e-6 * force_20_mm_away_n);
    // arcsin(1/2) = π/6.
    EXPECT_NEAR(pressure.force_n(at_mm(7)), 0.9 / 56.548667764616276 / 3 * 4, 1e-12);
    EXPECT_EQ(pressure.force_n(at_mm(5.5)), 0) << "under the punch there is its own pressure";
    EXPECT_EQ(pressure.force_n(at_mm(6)), 0);
}

// 20 mm at 8 m/s are 2.5 ms.
TEST(IndenterWave, ComesLaterByDistanceOverSpeed) {
    const IndenterWave wave({.tip = IndenterTip::flat,
                             .radius_mm = 1,
                             .force_n = 0.3,
                             .press = {.begin_s = 1, .rise_s = 0.1, .hold_s = 0.1, .fall_s = 0.1}},
                            half_space, {.speed_m_per_s = 8, .depth_mm = 3, .reach_mm = 60},
                            Aperture(wave_pitch_mm));
    const auto force_n = [&](double s) { return wave.at(at(s)).force_n(at_mm(20)); };
    EXPECT_EQ(force_n(1.0025), 0);
    EXPECT_NEAR(force_n(1.0525), force_20_mm_away_n / 2, 1e-6 * force_20_mm_away_n);
    EXPECT_NEAR(force_n(1.15), force_20_mm_away_n, 1e-6 * force_20_mm_away_n);
    EXPECT_NEAR(force_n(1.2775), force_20_mm_away_n / 4, 1e-6 * force_20_mm_away_n);
    EXPECT_EQ(force_n(1.3026), 0);
}

TEST(IndenterWave, TouchesWhatIsWithinItsReachUntilItHasPassed) {
    const IndenterWave wave({.x_mm = 5, .y_mm = -3, .press = {.begin_s = 1, .hold_s = 0.1}}, half_space,
                            {.speed_m_per_s = 8, .reach_mm = 40}, Aperture(wave_pitch_mm));
    for (const double s : {1.0, 1.1, 1.1049}) {
        const auto pressure = wave.at(at(s));
        EXPECT_EQ(pressure.rows().from_mm, -43);
        EXPECT_EQ(pressure.rows().to_mm, 37);
        EXPECT_DOUBLE_EQ(pressure.columns(21).from_mm, 5 - 32);
        EXPECT_DOUBLE_EQ(pressure.columns(21).to_mm, 5 + 32);
    }
    // 40 mm at 8 m/s are 5 ms.
    for (const double s : {0.999, 1.1051}) {
        const auto pressure = wave.at(at(s));
        EXPECT_FALSE(pressure.rows().contains(-3));
        EXPECT_FALSE(pressure.columns(-3).contains(5));
    }
}

// A sphere's wave is that of the disc on which it bore when it was sent.
TEST(IndenterWave, HasTheRadiusOfASpheresContact) {
    const IndenterParameters sphere{.radius_mm = 4, .force_n = 0.3};
    const IndenterWave wave(sphere, half_space, {.speed_m_per_s = 8, .depth_mm = 3, .reach_mm = 60},
                            Aperture(wave_pitch_mm));
    const double radius_mm = DiscContact::sphere_disc_mm(0.3, 4, half_space);
    ASSERT_GT(radius_mm, 1);
    EXPECT_NEAR(wave.at(at(1)).force_n(at_mm(20)),
                0.9 / 56.548667764616276 * 2 / std::numbers::pi * std::asin(radius_mm / 20) * 4, 1e-12);
}

}  // namespace
}  // namespace afferent
