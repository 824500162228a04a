// What presses the skin, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "afferent/hand/grasp_contact.hpp"
#include "afferent/hand/grating.hpp"
#include "afferent/hand/indenter.hpp"
#include "afferent/hand/sliding_edge.hpp"
#include "afferent/hand/texture.hpp"

namespace afferent {
namespace {

TimePoint after(double time_s) { return scene_start + rounded(Seconds(time_s)); }

// The sum over the cells of an unbounded grid that the pressure says it touches, and over those around them.
template <Pressure P>
struct OnGrid {
    double touched_n = 0;
    double beyond_n = 0;  // the largest force on a cell that it says it does not touch
    double x_moment = 0;
    double y_moment = 0;
    int cells = 0;

    OnGrid(const P& pressure, double pitch_mm, int half) {
        const Stretch rows = pressure.rows(pitch_mm);
        for (int j = -half; j <= half; ++j)
            for (int i = -half; i <= half; ++i) {
                const SkinCell cell{i * pitch_mm, j * pitch_mm, pitch_mm};
                const double force_n = pressure.force_n(cell);
                if (rows.contains(cell.y_mm) && pressure.columns(cell.y_mm, pitch_mm).contains(cell.x_mm)) {
                    touched_n += force_n;
                    x_moment += force_n * cell.x_mm;
                    y_moment += force_n * cell.y_mm;
                    ++cells;
                } else {
                    beyond_n = std::max(beyond_n, std::abs(force_n));
                }
            }
    }
};

// Whatever the pitch and wherever the contact lies among the cells. The parts are differences of numbers
// below 1/4, which rounds each by 1e-16.
TEST(DiscContact, BearsItsLoad) {
    for (const auto tip : {DiscContact::Tip::flat, DiscContact::Tip::sphere})
        for (const double pitch_mm : {0.13, 0.5, 3.0, 20.0})
            for (const double x_mm : {0.0, 0.21, -1.3}) {
                const DiscContact contact{tip, x_mm, 0.7 * x_mm, 2.5, 0.4};
                const OnGrid all(contact, pitch_mm, static_cast<int>(6 / pitch_mm) + 2);
                EXPECT_NEAR(all.touched_n, 0.4, 1e-12) << pitch_mm;
                EXPECT_LT(all.beyond_n, 1e-15) << "it touches what it says";
                const double area = static_cast<double>(all.cells) * pitch_mm * pitch_mm;
                const double wider = 2.5 + 1.5 * pitch_mm;
                EXPECT_LE(area, std::numbers::pi * wider * wider) << "and hardly more";
                if (pitch_mm < 1) {
                    // Moments of cells are those of their middles: off by a part of a pitch at the border.
                    EXPECT_NEAR(all.x_moment / 0.4, x_mm, 0.1 * pitch_mm);
                    EXPECT_NEAR(all.y_moment / 0.4, 0.7 * x_mm, 0.1 * pitch_mm);
                }
            }
}

TEST(DiscContact, HasThePressureOfPunchAndSphere) {
    const double a_mm = 1.5;
    for (const double r_mm : {0.0, 0.4, 1.1, 1.4}) {
        const double root = std::sqrt(a_mm * a_mm - r_mm * r_mm);
        // A small cell at that distance, askew. Its curvature is the error: (width/distance to the border)².
        const SkinCell cell{0.6 * r_mm, 0.8 * r_mm, 0.002};
        const double area_mm2 = cell.width_mm * cell.width_mm;
        const double flat = 2 / (2 * std::numbers::pi * a_mm * root);
        const double sphere = 3 * 2.0 / (2 * std::numbers::pi * std::pow(a_mm, 3)) * root;
        EXPECT_NEAR((DiscContact{DiscContact::Tip::flat, 0, 0, a_mm, 2}.force_n(cell)) / area_mm2, flat,
                    1e-4 * flat);
        EXPECT_NEAR((DiscContact{DiscContact::Tip::sphere, 0, 0, a_mm, 2}.force_n(cell)) / area_mm2, sphere,
                    1e-4 * sphere);
    }
}

// Hertz: a² = R d, whether the load is the depth or the force that goes with it.
TEST(Indenter, GoesAsDeepAsItsForce) {
    const ElasticSkin skin{.modulus_kpa = 60, .poisson = 0.3};
    const Indenter by_depth({.radius_mm = 4, .depth_mm = 0.5}, skin);
    const DiscContact contact = by_depth.at(after(1));
    EXPECT_NEAR(contact.radius_mm, std::sqrt(4 * 0.5), 1e-12);
    EXPECT_NEAR(contact.load_n, 4.0 / 3 * 0.06 / (1 - 0.09) * std::sqrt(4.0) * std::pow(0.5, 1.5), 1e-12);
    const Indenter by_force({.radius_mm = 4, .force_n = contact.load_n}, skin);
    EXPECT_NEAR(by_force.at(after(1)).radius_mm, contact.radius_mm, 1e-12);
    const Indenter punch({.tip = DiscContact::Tip::flat, .radius_mm = 4, .depth_mm = 0.5}, skin);
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
                            {});
    EXPECT_EQ(indenter.at(after(0.9)).load_n, 0);
    EXPECT_EQ(indenter.at(after(0.9)).rows(1).from_mm, indenter.at(after(0.9)).rows(1).to_mm) << "no cell";
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
                                .press = {.begin_s = 2}});
        const PressedEdge pressed = edge.at(after(2.05));
        EXPECT_NEAR(pressed.middle_mm, 1.5, 1e-12);
        const OnGrid all(pressed, 0.25, 40);
        EXPECT_LT(all.beyond_n, 1e-12) << degrees;
        EXPECT_GT(all.touched_n, 0) << degrees;
        // The middle of what is touched on a square grid lies on the edge's own.
        const Heading heading = Heading::of_degrees(degrees);
        EXPECT_NEAR(heading.along(all.x_moment, all.y_moment) / all.touched_n, 1.5, 0.05) << degrees;
        EXPECT_EQ(edge.at(after(1.9)).rows(0.25).from_mm, edge.at(after(1.9)).rows(0.25).to_mm);
    }
}

TEST(GraspContact, GrowsWithTheCubeRootOfItsShare) {
    const GraspContact contact(3, 4, 0.4, 8, {{0.5, 0}, {1, 10}}, {});
    EXPECT_EQ(contact.at(after(0.2)).load_n, 0);
    EXPECT_NEAR(contact.at(after(0.75)).load_n, 0.4 * 5, 1e-12);
    EXPECT_NEAR(contact.at(after(2)).radius_mm / contact.at(after(0.5625)).radius_mm, 2, 1e-9)
        << "eight times the force";
    const double modulus = 0.05 / (1 - 0.4 * 0.4);  // of 50 kPa
    EXPECT_NEAR(std::pow(contact.at(after(2)).radius_mm, 3), 3 * 4.0 * 8 / (4 * modulus), 1e-9);
}

// ---- surfaces ----

constexpr Pad pad{.width_mm = 10, .height_mm = 8, .peak_kpa = 12, .stiffness_kpa_per_mm = 20};

template <Relief R>
SlidingSurface<R> sliding(R relief, double direction_deg = 0) {
    return SlidingSurface<R>(std::move(relief), pad, direction_deg, 25, {});
}

// The paraboloid over an ellipse: peak · area / 2. A midpoint rule over cells of 0.1 mm is off by a part in
// (0.1/4)².
TEST(Grating, WithoutGroovesIsSmooth) {
    const OnGrid all(sliding(Grating{.depth_mm = 0}).at(after(0.3)), 0.1, 60);
    const double load_n = 0.012 * std::numbers::pi / 4 * 10 * 8 / 2;
    EXPECT_NEAR(all.touched_n, load_n, 1e-3 * load_n);
}

// With deep grooves only the ridges bear, whether a cell is wider than a period or not, and the pattern moves
// with the surface.
TEST(Grating, BearsOnItsRidges) {
    const Grating grating{.period_mm = 2, .ridge_mm = 0.5, .depth_mm = 5};
    const double smooth_n = 0.012 * std::numbers::pi / 4 * 10 * 8 / 2;
    // Under a smooth surface, on the pad's axis.
    const auto smooth_kpa = [](double x_mm) { return 12 * (1 - x_mm * x_mm / 25); };
    for (const double pitch_mm : {0.1, 0.4}) {
        const OnGrid all(sliding(grating).at(after(0.3)), pitch_mm, 80);
        // Five periods do not average the paraboloid better than that.
        EXPECT_NEAR(all.touched_n, 0.25 * smooth_n, 0.02 * smooth_n) << pitch_mm;
    }
    const auto surface = sliding(grating);
    for (const double time_s : {0.0, 0.04, 0.1}) {
        const auto pressed = surface.at(after(time_s));
        const double ridge_mm = 25 * time_s;  // where a ridge begins
        EXPECT_NEAR(pressed.force_n({std::fmod(ridge_mm, 2) + 0.25, 0, 0.1}),
                    1e-3 * smooth_kpa(std::fmod(ridge_mm, 2) + 0.25) * 0.01, 1e-12);
        EXPECT_EQ(pressed.force_n({std::fmod(ridge_mm, 2) + 1.2, 0, 0.1}), 0);
    }
    // In the grooves of a shallow grating the pressure is less by stiffness · depth.
    const auto shallow_surface = sliding(Grating{.period_mm = 2, .ridge_mm = 0.5, .depth_mm = 0.1});
    const auto shallow = shallow_surface.at(scene_start);
    EXPECT_NEAR(shallow.force_n({1.2, 0, 0.1}), 1e-3 * (smooth_kpa(1.2) - 20 * 0.1) * 0.01, 1e-12);
}

TEST(Texture, IsAsRoughAsItSays) {
    const Roughness roughness{.rms_mm = 0.02, .longest_mm = 4, .shortest_mm = 1, .hurst = 0.5, .seed = 3};
    const Texture texture(roughness);
    EXPECT_EQ(texture.side_mm(), 16);
    double sum = 0;
    double squares = 0;
    constexpr int side = 64;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
            const double height = texture.mean_height_mm(0.25 * i + 0.125, 0.25 * j + 0.125, 0.25);
            sum += height;
            squares += height * height;
        }
    EXPECT_NEAR(sum / (side * side), 0, 1e-12);
    EXPECT_NEAR(std::sqrt(squares / (side * side)), 0.02, 1e-12) << "these are its pixels";
    // It repeats itself, and is another for another seed.
    EXPECT_NEAR(texture.mean_height_mm(3.1, -2.2, 0.6), texture.mean_height_mm(3.1 + 16, -2.2 - 32, 0.6),
                1e-12);
    Roughness other = roughness;
    other.seed = 4;
    EXPECT_GT(
        std::abs(Texture(other).mean_height_mm(3.1, -2.2, 0.6) - texture.mean_height_mm(3.1, -2.2, 0.6)),
        1e-4);
}

// The mean over a square is that of the squares it is cut into, wherever its borders lie, and more than a
// repeat's away.
TEST(Texture, AveragesExactly) {
    const Texture texture({1, 2, 3, 4, 5, 6, 7, 8, 10}, 3, 0.5);
    const double mean = 46.0 / 9;
    EXPECT_NEAR(texture.mean_height_mm(0.25, 0.25, 0.5), 1 - mean, 1e-12);
    EXPECT_NEAR(texture.mean_height_mm(0.75, 0.25, 0.5), 2 - mean, 1e-12);
    EXPECT_NEAR(texture.mean_height_mm(0.25, 0.75, 0.5), 4 - mean, 1e-12);
    EXPECT_NEAR(texture.mean_height_mm(-0.25, -0.25, 0.5), 10 - mean, 1e-12);
    EXPECT_NEAR(texture.mean_height_mm(0.5, 0.5, 1), (1 + 2 + 4 + 5) / 4.0 - mean, 1e-12);
    EXPECT_NEAR(texture.mean_height_mm(0.75, 0.75, 1.5), 0, 1e-12);
    for (const double u : {-4.03, 0.31, 2.9})
        for (const double width : {0.2, 1.7}) {
            double quarters = 0;
            for (const double x : {-0.25, 0.25})
                for (const double y : {-0.25, 0.25})
                    quarters += texture.mean_height_mm(u + x * width, 1.1 + y * width, width / 2) / 4;
            EXPECT_NEAR(texture.mean_height_mm(u, 1.1, width), quarters, 1e-12);
        }
}

// Longer waves are higher: from one octave to the next, the power falls by 2^(2H).
TEST(Texture, HasThePowerOfItsHurstExponent) {
    const double hurst = 0.7;
    const Texture texture(Roughness{.rms_mm = 1, .longest_mm = 8, .shortest_mm = 0.5, .hurst = hurst});
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
                    const double height =
                        texture.mean_height_mm((i + 0.5) * 0.125, (row + 0.5) * 0.125, 0.125);
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
        const Texture relief{Roughness{}};
        const PressedSurface<Texture> pressed{&relief, of, Heading{}, 0, load};
        return pressed.rows(0.25).contains(of.y_mm) && pressed.columns(of.y_mm, 0.25).contains(of.x_mm);
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
    const auto along_x = sliding(Texture(Roughness{}));
    const auto along_y = sliding(Texture(Roughness{}), 90);
    // What is at a place of the pad comes from where it was before, and at 90° y takes the part of x.
    const SkinCell here{0.5, 0, 0.25};
    const SkinCell before{0, 0, 0.25};
    const auto height_kpa = [](const auto& pressed, const SkinCell& cell) {
        return pressed.force_n(cell) / (cell.width_mm * cell.width_mm) * 1e3 -
               pad.smooth_kpa(cell.x_mm, cell.y_mm, 1);
    };
    EXPECT_NEAR(height_kpa(along_x.at(after(0.02)), here), height_kpa(along_x.at(scene_start), before), 1e-9);
    EXPECT_NEAR(height_kpa(along_y.at(after(0.02)), {0, 0.5, 0.25}),
                height_kpa(along_y.at(scene_start), before), 1e-9);
}

}  // namespace
}  // namespace afferent
