#include "afferent/decoders/edge_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double per_degree = std::numbers::pi / 180;

double turn_between(double a_deg, double b_deg) {
    const double off = std::fmod(std::abs(a_deg - b_deg), 180);
    return std::min(off, 180 - off);
}

// A jittered lattice of 11 × 7 afferents 1.2 mm apart, whose thresholds differ by a factor of e^±spread.
std::vector<EdgeFit::Afferent> fingertip_of(unsigned seed, double spread) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> jitter(-0.3, 0.3), log(-spread, spread);
    std::vector<EdgeFit::Afferent> afferents;
    for (int y = -3; y <= 3; ++y)
        for (int x = -5; x <= 5; ++x)
            afferents.push_back(
                {{1.2 * x + jitter(random), 1.2 * y + jitter(random), 0.25}, std::exp(log(random))});
    return afferents;
}

struct Slide {
    double direction_deg, speed_mm_per_s, jitter_s;
};

std::vector<EdgeFit::First> firsts_of(const std::vector<EdgeFit::Afferent>& afferents, const Slide& slide,
                                      unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> jitters;
    std::vector<EdgeFit::First> firsts;
    for (std::uint32_t i = 0; i < afferents.size(); ++i) {
        const auto& [field, threshold] = afferents[i];
        const double along = field.x_mm * std::cos(slide.direction_deg * per_degree) +
                             field.y_mm * std::sin(slide.direction_deg * per_degree);
        // The edge drives from further away who is more sensitive.
        firsts.push_back({i, 1 + (along + 0.3 * std::log(threshold)) / slide.speed_mm_per_s +
                                 slide.jitter_s * jitters(random)});
    }
    return firsts;
}

// Plane and polynomial are what the times are made of.
TEST(EdgeFit, IsExactForASlideWithoutNoise) {
    for (const double spread : {0.0, 0.8}) {
        const auto afferents = fingertip_of(3, spread);
        EdgeFit fit(afferents);
        for (double direction = 0; direction < 360; direction += 27)
            for (const double speed : {2.0, 20.0, 200.0}) {
                const auto edge = fit(firsts_of(afferents, {direction, speed, 0}, 1));
                ASSERT_TRUE(edge.slides);
                // The least spread of times, 10 µs, is 0.02 µs per mm of lever; the ridge that closes the
                // polynomial takes 1e-6 of it.
                EXPECT_NEAR(edge.direction_deg, direction, 1e-3);
                EXPECT_LT(turn_between(edge.orientation_deg, direction + 90), 1e-3);
                EXPECT_NEAR(edge.speed_mm_per_s, speed, 1e-4 * speed);
            }
    }
}

// Of 300 slides; three binomial standard deviations (2.7 and 1.2 %), and 5 % because a deviation estimated
// from 77 times is itself known within 8 %.
TEST(EdgeFit, KnowsHowSureItIsOfASlide) {
    constexpr int slides = 300;
    int within_one = 0, within_two = 0;
    for (unsigned seed = 0; seed < slides; ++seed) {
        const auto afferents = fingertip_of(seed, 0.5);
        EdgeFit fit(afferents);
        const double direction = 1.2 * seed;
        const auto edge = fit(firsts_of(afferents, {direction, 20, 5e-3}, seed + 1000));
        ASSERT_TRUE(edge.slides);
        const double off = turn_between(edge.orientation_deg, direction + 90) / edge.sigma_deg;
        within_one += off < 1;
        within_two += off < 2;
    }
    EXPECT_NEAR(within_one / double{slides}, 0.683, 0.13);
    EXPECT_NEAR(within_two / double{slides}, 0.954, 0.086);
}

// With more jitter a slide is less and less sure, until it is no longer taken for one.
TEST(EdgeFit, TakesForASlideWhatIsKnownWithinATenth) {
    double least_sure = 0;
    int slides = 0;
    for (unsigned seed = 0; seed < 600; ++seed) {
        const auto afferents = fingertip_of(seed, 0.5);
        EdgeFit fit(afferents);
        const auto edge = fit(firsts_of(afferents, {1.2 * seed, 20, 0.2e-3 * seed}, seed + 1000));
        if (!edge.slides) continue;
        ++slides;
        // The variance of the slowness over its square: the part across the slide and the part along it.
        const double unsure = std::pow(edge.sigma_deg * per_degree, 2) +
                              std::pow(edge.speed_sigma_mm_per_s / edge.speed_mm_per_s, 2);
        least_sure = std::max(least_sure, unsure);
    }
    EXPECT_GT(slides, 300);
    EXPECT_LT(slides, 600);
    EXPECT_LE(std::sqrt(least_sure), 1.0 / 10 * (1 + 1e-9));
    EXPECT_GT(std::sqrt(least_sure), 1.0 / 12);
}

// One in six fires whenever it likes: biweights leave it out, and the rest is as without.
TEST(EdgeFit, IsNotMisledByAFew) {
    const auto afferents = fingertip_of(5, 0.5);
    EdgeFit fit(afferents);
    auto firsts = firsts_of(afferents, {35, 20, 1e-3}, 2);
    const auto without = fit(firsts);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> any(0, 2);
    for (std::size_t i = 0; i < firsts.size(); i += 6) firsts[i].time_s = any(random);
    const auto with = fit(firsts);
    ASSERT_TRUE(with.slides);
    // A sixth fewer are 1.1 times as uncertain; three standard deviations of each.
    EXPECT_LT(turn_between(with.orientation_deg, 125), 3 * 1.1 * without.sigma_deg + 3 * with.sigma_deg);
    EXPECT_LT(turn_between(with.orientation_deg, 125), 0.5);
}

// The pressure of an edge under a Gaussian field of 0.5 mm and itself 0.25 mm wide, pressed on within 50 ms:
// who is beneath it reaches its threshold first.
std::vector<EdgeFit::First> pressed_on(const std::vector<EdgeFit::Afferent>& afferents,
                                       double orientation_deg, double off_mm) {
    std::vector<EdgeFit::First> firsts;
    for (std::uint32_t i = 0; i < afferents.size(); ++i) {
        const auto& [field, threshold] = afferents[i];
        const double across = field.y_mm * std::cos(orientation_deg * per_degree) -
                              field.x_mm * std::sin(orientation_deg * per_degree) - off_mm;
        const double pressure = 8 * std::exp(-across * across / (2 * (0.25 + 0.0625)));
        if (pressure > threshold) firsts.push_back({i, 0.05 * threshold / pressure});
    }
    double begin_s = 1;
    for (const EdgeFit::First& first : firsts) begin_s = std::min(begin_s, first.time_s);
    for (EdgeFit::First& first : firsts) first.time_s -= begin_s;
    return firsts;
}

// Each afferent beneath an edge tells its place within the width of edge and field, 0.56 mm; some 17 of them
// along 8 mm or more, 2.3 mm in the root of mean squares, tell its direction within 0.56/(2.3 √17), 3.4
// degrees.
TEST(EdgeFit, FindsAnEdgeThatIsPressedOn) {
    double squares = 0;
    int edges = 0, within_two = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
        const auto afferents = fingertip_of(seed, 0.5);
        EdgeFit fit(afferents);
        const double orientation = 3.0 * seed;
        const auto edge = fit(pressed_on(afferents, orientation, 0.02 * seed - 0.6));
        ASSERT_FALSE(edge.slides) << seed;
        const double off = turn_between(edge.orientation_deg, orientation);
        squares += off * off;
        within_two += off < 2 * edge.sigma_deg;
        EXPECT_LT(edge.sigma_deg, 3 * 3.4) << seed;
        ++edges;
    }
    EXPECT_LT(std::sqrt(squares / edges), 3.4);
    // It may be surer than it says: it allows for drives that are off by a quarter.
    EXPECT_GE(within_two / double(edges), 0.95 - 3 * std::sqrt(0.95 * 0.05 / edges));
}

// Mirrored in the diagonal, a skin that is wider than high is higher than wide, and an edge at 30 degrees is
// one at 60 degrees. The iterations of the fit may end elsewhere within their tolerance.
TEST(EdgeFit, FindsAnEdgeOnASkinThatIsMirroredWhereItWas) {
    for (const double orientation : {10.0, 60.0, 130.0}) {
        auto afferents = fingertip_of(4, 0.5);
        const auto firsts = pressed_on(afferents, orientation, 0.3);
        const auto edge = EdgeFit(afferents)(firsts);
        for (EdgeFit::Afferent& afferent : afferents) std::swap(afferent.field.x_mm, afferent.field.y_mm);
        const auto mirrored = EdgeFit(afferents)(firsts);
        EXPECT_LT(turn_between(mirrored.orientation_deg, 90 - edge.orientation_deg), 1e-4);
        EXPECT_NEAR(mirrored.sigma_deg, edge.sigma_deg, 1e-4);
    }
}

// All at once and all alike: no direction.
TEST(EdgeFit, SaysWhereThereIsNoEdge) {
    std::vector<EdgeFit::Afferent> afferents;
    std::vector<EdgeFit::First> firsts;
    for (int y = -3; y <= 3; ++y)
        for (int x = -3; x <= 3; ++x) {
            afferents.push_back({{static_cast<double>(x), static_cast<double>(y), 0.25}, 1});
            if (x * x + y * y <= 4) firsts.push_back({static_cast<std::uint32_t>(afferents.size() - 1), 0});
        }
    const auto edge = EdgeFit(afferents)(firsts);
    EXPECT_FALSE(edge.slides);
    EXPECT_EQ(edge.sigma_deg, 52) << "any direction, all alike: 90/√3";
    afferents.resize(7);
    EXPECT_THROW(EdgeFit{afferents}, ParameterError);
}

}  // namespace
}  // namespace afferent
