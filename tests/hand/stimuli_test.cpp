// What presses the skin and how elements feel it, against closed forms and sums over pressure and aperture.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "afferent/hand/aperture.hpp"
#include "afferent/hand/dots.hpp"
#include "afferent/hand/grasp_contact.hpp"
#include "afferent/hand/grating.hpp"
#include "afferent/hand/indenter.hpp"
#include "afferent/hand/sliding_edge.hpp"
#include "afferent/hand/texture.hpp"

namespace afferent {
namespace {

TimePoint after(double time_s) { return scene_start + rounded(Seconds(time_s)); }

// ---- the aperture, as its paper has it ----

// (√(1 − (r/R)²))^m I_m(α √(1 − (r/R)²)) is a Kaiser-Bessel function of order m; 3/2 here.
double bell(double pitches) {
    const double square = 1 - std::pow(pitches / 2.5, 2);
    return square > 0 ? std::pow(square, 0.75) * std::cyl_bessel_i(1.5, std::sqrt(199 * square)) : 0;
}

// The midpoint rule on rings, which vanish smoothly at the end.
template <class F>
double sum_over_bell(const F& of_ring) {
    constexpr int rings = 2000;
    double sum = 0;
    for (int i = 0; i < rings; ++i) {
        const double r = 2.5 * (i + 0.5) / rings;
        sum += 2 * std::numbers::pi * r * bell(r) * of_ring(r) * 2.5 / rings;
    }
    return sum;
}

double bell_whole() {
    static const double whole = sum_over_bell([](double) { return 1; });
    return whole;
}

// The aperture's weight on a square pitch at a place, both in pitches.
double weight(double x, double y) { return bell(std::hypot(x, y)) / bell_whole(); }

// The mean of a surface under the aperture around a place, as a sum over steps × steps places. Where it is 0
// the aperture is not asked for.
template <class F>
double mean_under_aperture(const Position& place, double pitch_mm, int steps, const F& surface) {
    double sum = 0;
    for (int i = 0; i < steps; ++i)
        for (int k = 0; k < steps; ++k) {
            const double x = 5 * ((i + 0.5) / steps - 0.5);
            const double y = 5 * ((k + 0.5) / steps - 0.5);
            const double value = surface(place.x_mm + x * pitch_mm, place.y_mm + y * pitch_mm);
            if (value != 0) sum += weight(x, y) * value * 25 / (steps * steps);
        }
    return sum;
}

TEST(Aperture, IsAKaiserBesselFunction) {
    for (const double radians : {0.0, 0.3, 2.0, 4.5, 6.0, 2 * std::numbers::pi, 7.5, 11.0})
        EXPECT_NEAR(Aperture::transform(radians),
                    sum_over_bell([&](double r) { return std::cyl_bessel_j(0, radians * r); }) / bell_whole(),
                    5e-7)
            << radians;
    for (double radians = Aperture::most_radians; radians < 100; radians += 0.1)
        EXPECT_LT(std::abs(Aperture::transform(radians)), 1e-7);
    // A round kernel has the same variance along both axes, half of the mean square distance.
    EXPECT_NEAR(sum_over_bell([](double r) { return r * r / 2; }) / bell_whole(), Aperture::sd * Aperture::sd,
                1e-4);
}

TEST(Aperture, AddsUpToOneWhereverTheElementsLie) {
    for (const double x : {0.0, 0.2, 0.5})
        for (const double y : {0.0, 0.35, 0.5}) {
            double sum = 0;
            for (int i = -3; i <= 3; ++i)
                for (int j = -3; j <= 3; ++j) sum += weight(i - x, j - y);
            EXPECT_NEAR(sum, 1, 7e-5) << x << ", " << y;
        }
}

// The sum over the elements of an unbounded grid that the pressure says it touches, and over those around
// them.
template <Pressure P>
struct OnGrid {
    double touched_n = 0;
    double beyond_n = 0;  // the largest force on an element that it says it does not touch
    double x_moment = 0;
    double y_moment = 0;
    int elements = 0;

    OnGrid(const P& pressure, double pitch_mm, int half) {
        const Stretch rows = pressure.rows();
        for (int j = -half; j <= half; ++j)
            for (int i = -half; i <= half; ++i) {
                const Position place{i * pitch_mm, j * pitch_mm};
                const double force_n = pressure.force_n(place);
                if (rows.contains(place.y_mm) && pressure.columns(place.y_mm).contains(place.x_mm)) {
                    touched_n += force_n;
                    x_moment += force_n * place.x_mm;
                    y_moment += force_n * place.y_mm;
                    ++elements;
                } else {
                    beyond_n = std::max(beyond_n, std::abs(force_n));
                }
            }
    }
};

// Whatever the pitch and wherever the contact lies among the elements, as exactly as the aperture adds up.
TEST(DiscContact, BearsItsLoad) {
    for (const auto tip : {DiscContact::Tip::flat, DiscContact::Tip::sphere})
        for (const double pitch_mm : {0.13, 0.5, 3.0, 20.0})
            for (const double x_mm : {0.0, 0.21, -1.3}) {
                const DiscContact contact{tip, x_mm, 0.7 * x_mm, 2.5, 0.4, Aperture(pitch_mm)};
                const OnGrid all(contact, pitch_mm, static_cast<int>(6 / pitch_mm) + 4);
                EXPECT_NEAR(all.touched_n, 0.4, 1e-4 * 0.4) << pitch_mm;
                EXPECT_EQ(all.beyond_n, 0) << "it touches what it says";
                const double area = all.elements * pitch_mm * pitch_mm;
                const double wider = 2.5 + 2.5 * std::max(pitch_mm, 2.5 / 8) + pitch_mm;
                EXPECT_LE(area, std::numbers::pi * wider * wider) << "and hardly more";
                EXPECT_NEAR(all.x_moment / 0.4, x_mm, 1e-3 * pitch_mm);
                EXPECT_NEAR(all.y_moment / 0.4, 0.7 * x_mm, 1e-3 * pitch_mm);
            }
}

// The pressures of punch and sphere, at equal steps of the angles, under the aperture of an element at that
// distance. The midpoint rule is off by 1e-4 of the force in the middle.
TEST(DiscContact, IsFeltAsThePressureOfPunchAndSphereUnderTheAperture) {
    constexpr double pitch_mm = 0.5;
    for (const auto tip : {DiscContact::Tip::flat, DiscContact::Tip::sphere})
        for (const double a_mm : {0.05, 0.4, 1.1, 3.95}) {
            const DiscContact contact{tip, 0.3, -0.4, a_mm, 2, Aperture(pitch_mm)};
            const double largest_n = contact.force_n({0.3, -0.4});
            for (const double distance_mm : {0.0, 0.3, 0.9, a_mm, a_mm + 0.4, a_mm + 1.2}) {
                constexpr int steps = 400;
                constexpr int angles = 100;
                double expected_n = 0;
                for (int i = 0; i < steps; ++i) {
                    const double polar = std::numbers::pi / 2 * (i + 0.5) / steps;  // its sine is r/a
                    const double r_mm = a_mm * std::sin(polar);
                    const double shape = tip == DiscContact::Tip::flat ? 1 : 3 * std::pow(std::cos(polar), 2);
                    const double on_ring_n = 2 * shape * std::sin(polar) * std::numbers::pi / 2 / steps;
                    for (int k = 0; k < angles; ++k) {
                        const double angle = 2 * std::numbers::pi * (k + 0.5) / angles;
                        expected_n += on_ring_n / angles *
                                      weight((r_mm * std::cos(angle) - distance_mm) / pitch_mm,
                                             r_mm * std::sin(angle) / pitch_mm);
                    }
                }
                EXPECT_NEAR(contact.force_n({0.3 + 0.6 * distance_mm, -0.4 + 0.8 * distance_mm}), expected_n,
                            2e-4 * largest_n)
                    << "a " << a_mm << " at " << distance_mm;
            }
        }
}

// Hertz: a² = R d, whether the load is the depth or the force that goes with it.
TEST(Indenter, GoesAsDeepAsItsForce) {
    const ElasticSkin skin{.modulus_kpa = 60, .poisson = 0.3};
    const Indenter by_depth({.radius_mm = 4, .depth_mm = 0.5}, skin, Aperture(1));
    const DiscContact contact = by_depth.at(after(1));
    EXPECT_NEAR(contact.radius_mm, std::sqrt(4 * 0.5), 1e-12);
    EXPECT_NEAR(contact.load_n, 4.0 / 3 * 0.06 / (1 - 0.09) * std::sqrt(4.0) * std::pow(0.5, 1.5), 1e-12);
    const Indenter by_force({.radius_mm = 4, .force_n = contact.load_n}, skin, Aperture(1));
    EXPECT_NEAR(by_force.at(after(1)).radius_mm, contact.radius_mm, 1e-12);
    const Indenter punch({.tip = DiscContact::Tip::flat, .radius_mm = 4, .depth_mm = 0.5}, skin, Aperture(1));
    EXPECT_EQ(punch.at(after(1)).radius_mm, 4);
    EXPECT_NEAR(punch.at(after(1)).load_n, 2 * 4 * 0.06 / (1 - 0.09) * 0.5, 1e-12);
}

TEST(Indenter, PressesHoldsAndSlides) {
    const Indenter indenter({.x_mm = 1,
                             .y_mm = -2,
                             .direction_deg = 90,
                             .speed_mm_per_s = 10,
                             .force_n = 0.2,
                             .press = {.begin_s = 1, .rise_s = 0.5, .hold_s = 2, .fall_s = 1}},
                            {}, Aperture(1));
    EXPECT_EQ(indenter.at(after(0.9)).load_n, 0);
    EXPECT_EQ(indenter.at(after(0.9)).rows().from_mm, indenter.at(after(0.9)).rows().to_mm) << "none";
    EXPECT_NEAR(indenter.at(after(1.25)).load_n, 0.1, 1e-12);
    EXPECT_EQ(indenter.at(after(3)).load_n, 0.2);
    EXPECT_NEAR(indenter.at(after(4.25)).load_n, 0.05, 1e-12);
    EXPECT_EQ(indenter.at(after(4.6)).load_n, 0);
    EXPECT_NEAR(indenter.at(after(3)).x_mm, 1, 1e-12);
    EXPECT_NEAR(indenter.at(after(3)).y_mm, -2 + 10 * 2, 1e-12) << "from where it began to press";
}

TEST(Press, Vibrates) {
    const Press press{.begin_s = 0.5, .vibration_hz = 40, .vibration = 1.5};
    for (const double since_s : {0.0, 0.003, 0.011, 0.021})
        EXPECT_NEAR(press.at(after(0.5 + since_s)),
                    std::max(0.0, 1 + 1.5 * std::sin(2 * std::numbers::pi * 40 * since_s)), 1e-9)
            << "times are rounded to nanoseconds";
    EXPECT_EQ(press.at(after(0.5 + 0.75 / 40)), 0) << "it lifts off";
    EXPECT_EQ(Press().at(after(1e6)), 1);
}

TEST(SlidingEdge, TouchesAStripInEveryDirection) {
    for (const double degrees : {0.0, 30.0, 90.0, 135.0, 180.0, -90.0}) {
        const SlidingEdge edge({.direction_deg = degrees,
                                .speed_mm_per_s = 10,
                                .begin_mm = 1,
                                .half_width_mm = 0.8,
                                .press = {.begin_s = 2}},
                               Aperture(0.25));
        const PressedEdge pressed = edge.at(after(2.05));
        EXPECT_NEAR(pressed.middle_mm, 1.5, 1e-12);
        const OnGrid all(pressed, 0.25, 40);
        EXPECT_LT(all.beyond_n, 1e-9) << degrees << ": of 2e-3 under the edge";
        EXPECT_GT(all.touched_n, 0) << degrees;
        // The middle of what is touched on a square grid lies on the edge's own.
        const Heading heading = Heading::of_degrees(degrees);
        EXPECT_NEAR(heading.along(all.x_moment, all.y_moment) / all.touched_n, 1.5, 0.05) << degrees;
        EXPECT_EQ(edge.at(after(1.9)).rows().from_mm, edge.at(after(1.9)).rows().to_mm);
    }
}

// Hertz's pressure under the aperture, on a grid of places so fine that it is off by less than 1e-4; also of
// an edge of many pitches, which is felt through a wider aperture.
TEST(SlidingEdge, IsFeltAsThePressureOfHertzUnderTheAperture) {
    constexpr double pitch_mm = 0.5;
    for (const double a_mm : {0.02, 0.5, 2.0, 40.0}) {
        const SlidingEdge edge({.direction_deg = 30, .begin_mm = 0.7, .half_width_mm = a_mm, .peak_kpa = 30},
                               Aperture(pitch_mm));
        const Heading heading = Heading::of_degrees(30);
        const double unit_mm = std::max(pitch_mm, a_mm / 64);
        for (const double u_mm : {0.0, 0.1, 0.6, -1.0, a_mm, a_mm + 0.9}) {
            // Equal steps of the angle whose sine is the place on the edge, and of the place along it.
            constexpr int steps = 400;
            double expected_n = 0;
            for (int i = 0; i < steps; ++i) {
                const double angle = std::numbers::pi * ((i + 0.5) / steps - 0.5);
                const double on_line_kpa_mm =
                    30 * a_mm * std::pow(std::cos(angle), 2) * std::numbers::pi / steps;
                for (int k = 0; k < steps; ++k)
                    expected_n +=
                        1e-3 * on_line_kpa_mm * pitch_mm * pitch_mm / unit_mm * 5 / steps *
                        weight((a_mm * std::sin(angle) - u_mm) / unit_mm, 5 * ((k + 0.5) / steps - 0.5));
            }
            const double along_mm = 0.7 + u_mm;
            const double felt_n = edge.at(after(0)).force_n(
                {along_mm * heading.cos - 3 * heading.sin, along_mm * heading.sin + 3 * heading.cos});
            EXPECT_NEAR(felt_n, expected_n,
                        1e-4 * edge.at(after(0)).force_n({0.7 * heading.cos, 0.7 * heading.sin}))
                << a_mm << " at " << u_mm;
        }
    }
}

// Along a line of elements the forces add up to π/2 · a · peak for each millimetre of the edge.
TEST(SlidingEdge, BearsItsLoad) {
    for (const double pitch_mm : {0.1, 0.5, 2.0})
        for (const double middle_mm : {0.0, 0.17, 0.9}) {
            const SlidingEdge edge({.begin_mm = middle_mm, .half_width_mm = 0.5, .peak_kpa = 20},
                                   Aperture(pitch_mm));
            double sum_n = 0;
            for (int i = -60; i <= 60; ++i) sum_n += edge.at(after(0)).force_n({i * pitch_mm, 0});
            const double expected_n = std::numbers::pi / 2 * 0.5 * 0.02 * pitch_mm;
            EXPECT_NEAR(sum_n, expected_n, 1e-4 * expected_n) << pitch_mm;
        }
}

TEST(GraspContact, GrowsWithTheCubeRootOfItsShare) {
    const GraspContact contact(3, 4, 0.4, 8, {{0.5, 0}, {1, 10}}, {}, Aperture(1));
    EXPECT_EQ(contact.at(after(0.2)).load_n, 0);
    EXPECT_NEAR(contact.at(after(0.75)).load_n, 0.4 * 5, 1e-12);
    EXPECT_NEAR(contact.at(after(2)).radius_mm / contact.at(after(0.5625)).radius_mm, 2, 1e-9)
        << "eight times the force";
    const double modulus = 0.05 / (1 - 0.4 * 0.4);  // of 50 kPa
    EXPECT_NEAR(std::pow(contact.at(after(2)).radius_mm, 3), 3 * 4.0 * 8 / (4 * modulus), 1e-9);
}

// ---- surfaces ----

constexpr Pad pad{.width_mm = 10, .height_mm = 8, .peak_kpa = 12, .stiffness_kpa_per_mm = 20};

constexpr double fine_mm = 0.01;  // a pitch at which elements feel nearly points

template <Relief R>
SlidingSurface<R> sliding(R relief, double pitch_mm = fine_mm, double direction_deg = 0) {
    return SlidingSurface<R>(std::move(relief), pad, direction_deg, 25, {}, Aperture(pitch_mm));
}
double kpa(const auto& pressed, const Position& place) {
    return pressed.force_n(place) / pressed.aperture.n_per_kpa();
}

// The paraboloid over an ellipse: peak · area / 2. A midpoint rule over steps of 0.1 mm is off by a part in
// (0.1/4)².
TEST(Grating, WithoutGroovesIsSmooth) {
    const OnGrid all(sliding(Grating(2, 1, 0, Aperture(0.1)), 0.1).at(after(0.3)), 0.1, 60);
    const double load_n = 0.012 * std::numbers::pi / 4 * 10 * 8 / 2;
    EXPECT_NEAR(all.touched_n, load_n, 1e-3 * load_n);
}

// With deep grooves only the ridges bear, whether an aperture is wider than a period or not, and the pattern
// moves with the surface.
TEST(Grating, BearsOnItsRidges) {
    const double smooth_n = 0.012 * std::numbers::pi / 4 * 10 * 8 / 2;
    // Under a smooth surface, on the pad's axis.
    const auto smooth_kpa = [](double x_mm) { return 12 * (1 - x_mm * x_mm / 25); };
    for (const double pitch_mm : {0.1, 0.4}) {
        const OnGrid all(sliding(Grating(2, 0.5, 5, Aperture(pitch_mm)), pitch_mm).at(after(0.3)), pitch_mm,
                         80);
        // Five periods do not average the paraboloid better than that.
        EXPECT_NEAR(all.touched_n, 0.25 * smooth_n, 0.02 * smooth_n) << pitch_mm;
    }
    const auto surface = sliding(Grating(2, 0.5, 5, Aperture(fine_mm)));
    for (const double time_s : {0.0, 0.04, 0.1}) {
        const auto pressed = surface.at(after(time_s));
        const double ridge_mm = std::fmod(25 * time_s, 2);  // where a ridge begins
        EXPECT_NEAR(kpa(pressed, {ridge_mm + 0.25, 0}), smooth_kpa(ridge_mm + 0.25), 1e-3);
        EXPECT_NEAR(kpa(pressed, {ridge_mm + 1.2, 0}), 0, 1e-3);
    }
    // In the grooves of a shallow grating the pressure is less by stiffness · depth.
    const auto shallow_surface = sliding(Grating(2, 0.5, 0.1, Aperture(fine_mm)));
    EXPECT_NEAR(kpa(shallow_surface.at(scene_start), {1.2, 0}), smooth_kpa(1.2) - 20 * 0.1, 1e-3);
}

// The part of the aperture that lies on ridges, as a sum over its places.
TEST(Grating, IsFeltUnderTheAperture) {
    constexpr Pad flat{.width_mm = 1000, .height_mm = 1000, .peak_kpa = 1, .stiffness_kpa_per_mm = 20};
    for (const double period_mm : {0.3, 1.3, 8.0})
        for (const double pitch_mm : {0.2, 1.0}) {
            const double ridge_mm = 0.4 * period_mm;
            const Grating grating(period_mm, ridge_mm, 5, Aperture(pitch_mm));
            for (const double u_mm : {0.0, 0.31, -2.2, 5.9}) {
                constexpr int steps = 1000;
                double expected = 0;
                for (int i = 0; i < steps; ++i) {
                    const double x = 5 * ((i + 0.5) / steps - 0.5);
                    const double place_mm = u_mm + x * pitch_mm;
                    if (place_mm - period_mm * std::floor(place_mm / period_mm) >= ridge_mm) continue;
                    for (int k = 0; k < 100; ++k)
                        expected += weight(x, 5 * ((k + 0.5) / 100 - 0.5)) * 5 / steps * 5 / 100;
                }
                // A step of the border of a ridge holds up to 0.4 % of the aperture.
                EXPECT_NEAR(grating.mean_kpa(1, u_mm, 0, flat), expected, 0.004)
                    << period_mm << ' ' << pitch_mm << ' ' << u_mm;
            }
        }
}

// With much between them only the dots bear, to a two-hundredth of the pressure where an aperture is as much
// narrower than the spacing as here, in rows and columns that move with the surface.
TEST(Dots, BearTheLoadInASquareArray) {
    const double smooth_n = 0.012 * std::numbers::pi / 4 * 10 * 8 / 2;
    for (const double pitch_mm : {0.1, 0.4}) {
        const OnGrid all(sliding(Dots(0.8, 0.5, 5, Aperture(pitch_mm)), pitch_mm).at(after(0.3)), pitch_mm,
                         80);
        const double covered = std::numbers::pi * 0.25 * 0.25 / (0.8 * 0.8);
        // A hundred dots do not average the paraboloid better than that.
        EXPECT_NEAR(all.touched_n, covered * smooth_n, 0.02 * covered * smooth_n) << pitch_mm;
    }
    const auto smooth_kpa = [](double x_mm, double y_mm) {
        return 12 * (1 - x_mm * x_mm / 25 - y_mm * y_mm / 16);
    };
    const auto surface = sliding(Dots(2, 0.6, 5, Aperture(fine_mm)));
    for (const double time_s : {0.0, 0.04, 0.1}) {
        const auto pressed = surface.at(after(time_s));
        const double dot_mm = std::fmod(25 * time_s, 2);  // where a dot's middle is
        for (const double x_mm : {dot_mm, dot_mm + 0.25, dot_mm - 2}) {
            EXPECT_NEAR(kpa(pressed, {x_mm, 0}), smooth_kpa(x_mm, 0), 0.05) << x_mm;
            EXPECT_NEAR(kpa(pressed, {x_mm, 2}), smooth_kpa(x_mm, 2), 0.05) << x_mm;
        }
        EXPECT_NEAR(kpa(pressed, {dot_mm + 0.35, 0}), 0, 0.05);
        EXPECT_NEAR(kpa(pressed, {dot_mm, 0.35}), 0, 0.05);
        EXPECT_NEAR(kpa(pressed, {dot_mm + 1, 1}), 0, 0.05);
    }
    // Between shallow dots the pressure is less by stiffness · depth.
    EXPECT_NEAR(kpa(sliding(Dots(2, 0.6, 0.1, Aperture(fine_mm))).at(scene_start), {1, 1}),
                smooth_kpa(1, 1) - 20 * 0.1, 0.05);
}

// The part of the aperture that lies on dots, as a sum over its places.
TEST(Dots, AreFeltUnderTheAperture) {
    constexpr Pad flat{.width_mm = 1000, .height_mm = 1000, .peak_kpa = 1, .stiffness_kpa_per_mm = 20};
    for (const double spacing_mm : {0.5, 1.7, 6.0})
        for (const double pitch_mm : {0.2, 1.0}) {
            const double diameter_mm = 0.7 * spacing_mm;
            const Dots dots(spacing_mm, diameter_mm, 5, Aperture(pitch_mm));
            for (const Position& place : {Position{0, 0}, Position{0.31, 0.1}, Position{-2.2, 5.9}}) {
                const double expected =
                    mean_under_aperture(place, pitch_mm, 1000, [&](double u_mm, double v_mm) {
                        return std::hypot(std::remainder(u_mm, spacing_mm),
                                          std::remainder(v_mm, spacing_mm)) < diameter_mm / 2
                                   ? 1
                                   : 0;
                    });
                EXPECT_NEAR(dots.mean_kpa(1, place.x_mm, place.y_mm, flat), expected, 1e-3)
                    << spacing_mm << ' ' << pitch_mm << ' ' << place.x_mm;
            }
        }
}

constexpr Roughness rough{.rms_mm = 0.02, .longest_mm = 4, .shortest_mm = 1, .hurst = 0.5, .seed = 3};

TEST(Texture, IsAsRoughAsItSays) {
    const Texture texture(rough, Aperture(fine_mm));
    EXPECT_EQ(texture.side_mm(), 16);
    double sum = 0;
    double squares = 0;
    constexpr int side = 64;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            const double height = texture.mean_height_mm(0.25 * i, 0.25 * j);
            sum += height;
            squares += height * height;
        }
    EXPECT_NEAR(sum / (side * side), 0, 1e-12);
    // At its pixels. The aperture of 0.01 mm takes (q · 0.006)² of the power of a wave of 1 mm.
    EXPECT_NEAR(std::sqrt(squares / (side * side)), 0.02, 2e-3 * 0.02);
    // It repeats itself, and is another for another seed.
    EXPECT_NEAR(texture.mean_height_mm(3.1, -2.2), texture.mean_height_mm(3.1 + 16, -2.2 - 32), 1e-12);
    Roughness other = rough;
    other.seed = 4;
    EXPECT_GT(std::abs(Texture(other, Aperture(fine_mm)).mean_height_mm(3.1, -2.2) -
                       texture.mean_height_mm(3.1, -2.2)),
              1e-4);
}

// An element of a coarser grid feels the mean of the heights under its aperture. The splines are off by some
// 1 % of the height of the shortest wave, of which little is left under the aperture.
TEST(Texture, IsFeltUnderTheAperture) {
    const Texture fine(rough, Aperture(fine_mm));
    for (const double pitch_mm : {0.5, 1.0}) {
        const Texture coarse(rough, Aperture(pitch_mm));
        for (const Position& place : {Position{0.2, 0.4}, Position{3.1, -2.2}, Position{30, 11.3}}) {
            const double expected_mm = mean_under_aperture(
                place, pitch_mm, 60,
                [&](double u_mm, double v_mm) { return fine.mean_height_mm(u_mm, v_mm); });
            EXPECT_NEAR(coarse.mean_height_mm(place.x_mm, place.y_mm), expected_mm, 0.002 * 0.02) << pitch_mm;
        }
    }
}

// Longer waves are higher: from one octave to the next, the power falls by 2^(2H).
TEST(Texture, HasThePowerOfItsHurstExponent) {
    const double hurst = 0.7;
    const Texture texture(Roughness{.rms_mm = 1, .longest_mm = 8, .shortest_mm = 0.5, .hurst = hurst},
                          Aperture(fine_mm));
    // The periodogram of profiles along u, by the number of waves a side (32 mm), summed over all v and over
    // the waves of an octave.
    constexpr int n = 256;
    const auto octave = [&](int first) {
        double power = 0;
        for (int row = 0; row < n; row += 4)
            for (int k = first; k < 2 * first; ++k) {
                double re = 0;
                double im = 0;
                for (int i = 0; i < n; ++i) {
                    const double height = texture.mean_height_mm(i * 0.125, row * 0.125);
                    re += height * std::cos(2 * std::numbers::pi * k * i / n);
                    im += height * std::sin(2 * std::numbers::pi * k * i / n);
                }
                power += re * re + im * im;
            }
        return power;
    };
    // Waves that lie askew are longer along u than they are, up to the shortest, and a few dozen random waves
    // an octave scatter by some 20 %.
    EXPECT_NEAR(std::log2(octave(8) / octave(16)), 2 * hurst, 0.5);
}

TEST(SlidingSurface, TouchesWhatItsLoadBringsToThePadAndNothingWithoutPressure) {
    const auto touches_centre = [](const Pad& of, double load) {
        const Texture relief(Roughness{}, Aperture(0.25));
        const PressedSurface<Texture> pressed{&relief, of, Heading{}, 0, load, Aperture(0.25)};
        return pressed.rows().contains(of.y_mm) && pressed.columns(of.y_mm).contains(of.x_mm);
    };
    Pad elsewhere = pad;
    elsewhere.y_mm = 3;
    EXPECT_TRUE(touches_centre(elsewhere, 1e-6));
    EXPECT_FALSE(touches_centre(elsewhere, 0));
    EXPECT_FALSE(touches_centre(elsewhere, -1));
    elsewhere.peak_kpa = 0;
    EXPECT_FALSE(touches_centre(elsewhere, 1));
}

TEST(SlidingSurface, SlidesInItsDirection) {
    const auto along_x = sliding(Texture(Roughness{}, Aperture(0.25)), 0.25);
    const auto along_y = sliding(Texture(Roughness{}, Aperture(0.25)), 0.25, 90);
    // What is at a place of the pad comes from where it was before, and at 90° y takes the part of x.
    const Position here{0.5, 0};
    const Position before{0, 0};
    const auto height_kpa = [](const auto& pressed, const Position& place) {
        return kpa(pressed, place) - pad.smooth_kpa(place.x_mm, place.y_mm, 1);
    };
    EXPECT_NEAR(height_kpa(along_x.at(after(0.02)), here), height_kpa(along_x.at(scene_start), before), 1e-9);
    EXPECT_NEAR(height_kpa(along_y.at(after(0.02)), {0, 0.5}), height_kpa(along_y.at(scene_start), before),
                1e-9);
}

}  // namespace
}  // namespace afferent
