#include "afferent/decoders/pressure_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "afferent/decoders/small_matrix.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Fields of 0.25 mm² on a square lattice, a millimetre apart.
std::vector<SkinField> lattice_of_fields(int half = 6) {
    std::vector<SkinField> fields;
    for (int y = -half; y <= half; ++y)
        for (int x = -half; x <= half; ++x)
            fields.push_back({static_cast<double>(x), static_cast<double>(y), 0.25});
    return fields;
}

std::vector<PressureFit::Reading> readings_under(const PressureFit& fit, const PressureShape::Values& values,
                                                 double sigma) {
    std::vector<PressureFit::Reading> readings;
    for (const SkinField& field : fit.fields()) {
        const double read = fit.shape(values).read_by(field);
        readings.push_back({read, read, sigma, sigma});
    }
    return readings;
}

TEST(SmallMatrix, SolvesAndInverts) {
    SmallMatrix<3> a{{{4, 2, 1}, {2, 5, 3}, {1, 3, 6}}};
    const SmallVector<3> x{1, -2, 3};
    SmallVector<3> b{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) b[i] += a[i][j] * x[j];
    SmallMatrix<3> l = a;
    ASSERT_TRUE(factor(l));
    const SmallMatrix<3> inverted = inverse(l);
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(solve(l, b)[i], x[i], 1e-12);
        double one = 0;
        for (std::size_t k = 0; k < 3; ++k) one += inverted[i][k] * a[k][i];
        EXPECT_NEAR(one, 1, 1e-12);
    }
    SmallMatrix<2> indefinite{{{1, 2}, {2, 1}}};
    EXPECT_FALSE(factor(indefinite));
}

// The closed form, against a sum over the shape itself.
TEST(PressureShape, IsReadThroughAFieldAsItsConvolution) {
    const PressureShape shape({std::log(2.0), 0.3, -0.2, std::log(0.5), 0.4, 0.3}, 0.25);
    const SkinField field{0.8, 0.1, 0.36};
    double sum = 0;
    constexpr double step = 0.02;
    for (double y = -6; y < 6; y += step)
        for (double x = -6; x < 6; x += step) {
            const double square = std::pow(x - field.x_mm, 2) + std::pow(y - field.y_mm, 2);
            sum += shape.read_by({x, y, 0}) * std::exp(-square / (2 * field.variance_mm2)) /
                   (2 * std::numbers::pi * field.variance_mm2) * step * step;
        }
    // Sums over Gaussians that are far wider than the step are exact to rounding.
    EXPECT_NEAR(shape.read_by(field), sum, 1e-9);
}

// The prior pulls by (σ of the readings / its own)², some 1e-6 here.
TEST(PressureFit, FindsAShapeAsItIs) {
    const PressureFit fit(lattice_of_fields(), 1);
    for (const double angle : {0.0, 0.4, 1.1, 1.57, 2.3, 3.0})
        for (const double length : {0.0, 0.5, 1.2}) {
            const PressureShape::Values truth{std::log(0.01),
                                              0.37,
                                              -0.61,
                                              std::log(0.6),
                                              length * std::cos(2 * angle),
                                              length * std::sin(2 * angle)};
            const auto found = fit(readings_under(fit, truth, 1e-5)).values;
            for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(found[k], truth[k], 2e-3) << k;
        }
}

// Errors of the readings that are as large as they say come out as large as the fit says: 68 % of them within
// one standard deviation, and 95 % within two. Of 200 fits, binomial deviations are 3.3 and 1.5 %; three of
// them are allowed, and 3 % for what is not linear.
// Each field has read it at another time, up to 0.15 s ago, and nothing is known of its velocity but that.
TEST(PressureFit, FindsAShapeWhereItIsWhileItMoves) {
    const PressureFit fit(lattice_of_fields(), 1);
    const PressureShape::Values truth{std::log(0.01), 0.3, -0.4, std::log(0.8), 0.4, -0.3, 12, -7};
    std::mt19937_64 random(3);
    std::uniform_real_distribution<> age_s(0, 0.15);
    std::vector<PressureFit::Reading> readings;
    for (const SkinField& field : fit.fields()) {
        const double age = age_s(random);
        // As it would be read now where the field lay as far ahead as it has moved since.
        const double read =
            fit.shape(truth).read_by({field.x_mm + truth[PressureShape::vx] * age,
                                      field.y_mm + truth[PressureShape::vy] * age, field.variance_mm2});
        readings.push_back({read, read, 1e-6, 1e-6, age});
    }
    const PressureFit::Solution moving = fit(readings, true);
    for (std::size_t k = 0; k < PressureShape::parameters; ++k)
        EXPECT_NEAR(moving.values[k], truth[k], k < PressureShape::at_present ? 1e-3 : 0.05) << k;
    EXPECT_LT(fit.misfit(readings, fit.shape(moving.values)), 1);
    const PressureFit::Solution still = fit(readings);
    EXPECT_NEAR(still.values[PressureShape::vx], 0, 1e-3);
    EXPECT_NEAR(still.values[PressureShape::vy], 0, 1e-3);
    EXPECT_GT(fit.misfit(readings, fit.shape(still.values)), 1e4);
}

TEST(PressureFit, KnowsHowSureItIs) {
    const PressureFit fit(lattice_of_fields(), 1);
    const PressureShape::Values truth{std::log(0.01), 0.2, 0.4, std::log(0.8), 0.3, -0.2};
    std::mt19937 random(7);
    std::normal_distribution<double> error(0, 5e-4);
    int within_one = 0, within_two = 0;
    constexpr int fits = 200;
    for (int i = 0; i < fits; ++i) {
        auto readings = readings_under(fit, truth, 5e-4);
        for (PressureFit::Reading& reading : readings) reading.highest += error(random);
        for (PressureFit::Reading& reading : readings) reading.lowest = reading.highest;
        const PressureFit::Solution found = fit(readings);
        double variance = 0;
        for (const double each : found.deviation[PressureShape::x]) variance += each * each;
        const double off =
            std::abs(found.values[PressureShape::x] - truth[PressureShape::x]) / std::sqrt(variance);
        within_one += off < 1;
        within_two += off < 2;
    }
    EXPECT_NEAR(within_one / double{fits}, 0.683, 0.13);
    EXPECT_NEAR(within_two / double{fits}, 0.954, 0.075);
}

// A reading within its bounds costs nothing: a shape that is known where it is measured is found whatever the
// bounds above others are.
TEST(PressureFit, TakesBoundsForNoMoreThanBounds) {
    const PressureFit fit(lattice_of_fields(), 1);
    const PressureShape::Values truth{std::log(0.01), 0.2, 0.4, std::log(0.8), 0.3, -0.2};
    auto readings = readings_under(fit, truth, 1e-5);
    for (std::size_t i = 0; i < readings.size(); i += 3) {
        readings[i].lowest = 0;
        readings[i].highest *= 1.5;
    }
    const auto found = fit(readings).values;
    for (std::size_t k = 0; k < truth.size(); ++k) EXPECT_NEAR(found[k], truth[k], 2e-3) << k;
}

// One field alone tells a height and a place; the rest is the prior's, and finite.
TEST(PressureFit, FallsBackOnWhatIsUsual) {
    const PressureFit fit({{1, 2, 0.25}}, 1);
    const auto found = fit(std::vector<PressureFit::Reading>{{0.01, 0.01, 1e-3, 1e-3}});
    // The slope is a difference over 1e-5 mm.
    EXPECT_NEAR(found.values[PressureShape::x], 1, 1e-4);
    EXPECT_NEAR(found.values[PressureShape::y], 2, 1e-4);
    // The variance of a sphere's contact of the usual radius, 1 mm.
    EXPECT_NEAR(found.values[PressureShape::m], std::log(0.2), 0.2);
    for (const auto& row : found.deviation)
        for (const double each : row) EXPECT_TRUE(std::isfinite(each));
    EXPECT_THROW(PressureFit({}, 1), ParameterError);
    EXPECT_THROW(PressureFit({{1, 2, 0.25}}, 0), ParameterError);
}

}  // namespace
}  // namespace afferent
