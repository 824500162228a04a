// Elements and afferents in two dimensions.
#include "afferent/encoders/element_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr std::uint32_t most_places = 1'000'000;
constexpr Outline square_cm{Outline::Shape::rectangle, 10, 10};
constexpr Outline oval{Outline::Shape::ellipse, 16, 10};
constexpr double oval_mm2 = std::numbers::pi * 8 * 5;

double halfway(std::uint32_t, std::uint32_t) { return 0.5; }
// Any numbers from 0 to 1 that do not repeat.
double scattered(std::uint32_t index, std::uint32_t axis) {
    const double x = (2 * index + axis + 1) * std::numbers::phi;
    return x - std::floor(x);
}

std::vector<FieldWeight> gaussian_field(const ElementGrid& grid, const Position& centre, double sd_mm) {
    FieldRows rows;
    grid.add_gaussian_field(centre, sd_mm, rows);
    return {rows[0].begin(), rows[0].end()};
}

// What an afferent reads of a pressure p(place) in N/mm².
template <class Pressure>
double read(const ElementGrid& grid, const Position& centre, double sd_mm, Pressure&& pressure) {
    double sum = 0;
    for (const auto& [element, weight] : gaussian_field(grid, centre, sd_mm))
        sum += weight * pressure(grid.place(element)) * grid.pitch_mm() * grid.pitch_mm();
    return sum;
}

TEST(ElementGrid, CoversTheOutlineRowByRow) {
    const ElementGrid grid(square_cm, 2.5, most_places);
    ASSERT_EQ(grid.elements(), 16U);
    EXPECT_EQ(grid.place(0), (Position{-3.75, -3.75}));
    EXPECT_EQ(grid.place(1), (Position{-1.25, -3.75}));
    EXPECT_EQ(grid.place(15), (Position{3.75, 3.75}));
    for (const double pitch_mm : {0.2, 0.5}) {
        const ElementGrid fine(oval, pitch_mm, most_places);
        // About as many cells as lie on the border are cut, and as many of them count as do not: in a row of
        // such chances the sum strays by the square root.
        constexpr double border_mm = 42;
        EXPECT_NEAR(fine.elements() * pitch_mm * pitch_mm, oval_mm2,
                    pitch_mm * pitch_mm * std::sqrt(border_mm / pitch_mm));
        for (std::uint32_t i = 0; i < fine.elements(); ++i) EXPECT_TRUE(oval.contains(fine.place(i)));
    }
}

TEST(ElementGrid, RefusesTooManyCellsAndNone) {
    EXPECT_THROW(ElementGrid(square_cm, 0.001, most_places), ParameterError);
    // The centres of two by two cells lie at the corners of a square, outside this thin ellipse.
    EXPECT_THROW(ElementGrid({Outline::Shape::ellipse, 3, 3}, 2, 1), ParameterError);
    EXPECT_EQ(ElementGrid({Outline::Shape::ellipse, 3, 3}, 100, most_places).elements(), 1U);
}

// The mean of a pressure that is linear in place is its value at the centre.
TEST(GaussianFields, ReadMeanPressureWhateverThePitch) {
    const Position centre{0.37, -0.81};
    for (const double pitch_mm : {0.1, 0.5, 1.0}) {
        const ElementGrid grid(square_cm, pitch_mm, most_places);
        for (const double sd_mm : {0.02, 0.7, 1.2}) {
            const double uniform = read(grid, centre, sd_mm, [](const Position&) { return 0.03; });
            EXPECT_NEAR(uniform, 0.03, 1e-15) << pitch_mm << ' ' << sd_mm;
            if (sd_mm < pitch_mm) continue;
            const double linear =
                read(grid, centre, sd_mm, [](const Position& p) { return 3 + p.x_mm - 2 * p.y_mm; });
            // The cut at three deviations goes through cells.
            EXPECT_NEAR(linear, 3 + 0.37 + 2 * 0.81, 0.02) << pitch_mm << ' ' << sd_mm;
        }
    }
}

// Also where a row begins or ends: the nearest element weighs most, and the next e^(−½) of it.
TEST(GaussianFields, ReachEveryElementOfARow) {
    const ElementGrid grid(square_cm, 2.5, most_places);
    for (std::uint32_t i = 0; i < grid.elements(); ++i) {
        const bool ends_row = i % 4 == 3;
        double own = 0, next = 0;
        for (const auto& [element, weight] : gaussian_field(grid, grid.place(i), 2.5)) {
            if (element == i) own = weight;
            if (element == (ends_row ? i - 1 : i + 1)) next = weight;
        }
        EXPECT_GT(own, 0) << i;
        EXPECT_NEAR(next, own * std::exp(-0.5), 1e-12 * own) << i;
    }
}

// A Gaussian of a Gaussian has the sum of their variances.
TEST(GaussianFields, AreAsWideAsTheyAreSaidToBe) {
    constexpr double sd_mm = 1.1;
    constexpr double spot_mm = 0.6;
    const ElementGrid grid(square_cm, 0.1, most_places);
    for (const double away_mm : {0.0, 0.8, 1.6}) {
        const auto spot = [&](const Position& p) {
            return std::exp(-(std::pow(p.x_mm - away_mm, 2) + p.y_mm * p.y_mm) / (2 * spot_mm * spot_mm));
        };
        const double variance = sd_mm * sd_mm + spot_mm * spot_mm;
        const double expected = spot_mm * spot_mm / variance * std::exp(-away_mm * away_mm / (2 * variance));
        // What is cut off beyond three deviations is e^(−4.5) of the field, and so is what it is divided by.
        EXPECT_NEAR(read(grid, {0, 0}, sd_mm, spot), expected, 0.02 * spot_mm * spot_mm / variance)
            << away_mm;
    }
}

TEST(GaussianFields, OverlapAndEndAtTheOutline) {
    const ElementGrid grid(square_cm, 0.25, most_places);
    const auto uniform = [](const Position&) { return 1.0; };
    // Half of the field lies beyond the border, and three quarters beyond a corner.
    EXPECT_NEAR(read(grid, {5, 0}, 1, uniform), 0.5, 0.001);
    EXPECT_NEAR(read(grid, {5, 5}, 1, uniform), 0.25, 0.001);
    // Of an afferent that lies outside, by many deviations, the nearest element alone.
    const auto row = gaussian_field(grid, {20, 0.1}, 0.1);
    ASSERT_EQ(row.size(), 1U);
    EXPECT_NEAR(grid.place(row[0].element).x_mm, 4.875, 1e-12);
}

TEST(JitteredLattice, HasTheDensityWithinTheOutline) {
    for (const auto& [outline, area_mm2] : {std::pair(square_cm, 100.0), std::pair(oval, oval_mm2)})
        for (const double per_cm2 : {25.0, 70.0, 140.0, 2000.0}) {
            const double wanted = per_cm2 * area_mm2 / 100;
            for (const double jitter : {0.0, 0.6}) {
                const auto places = jittered_lattice(outline, per_cm2, jitter, most_places, scattered);
                // Rows and columns are whole, and the border cuts through cells.
                EXPECT_NEAR(static_cast<double>(places.size()), wanted, 1 + std::sqrt(wanted) / 2) << per_cm2;
                for (const Position& place : places) EXPECT_TRUE(outline.contains(place));
            }
        }
}

// In a rectangle of 2 : 1 all places of columns × rows count; one row or column more or fewer may fit better.
TEST(JitteredLattice, IsTheNearestToTheDensityOfThoseThatAreNearlySquare) {
    constexpr Outline two_by_one{Outline::Shape::rectangle, 20, 10};
    for (int wanted = 1; wanted < 200; ++wanted) {
        const double columns = std::max(1.0, std::round(std::sqrt(2.0 * wanted)));
        const double rows = std::max(1.0, std::round(wanted / columns));
        double nearest = wanted;
        for (const double c : {columns - 1, columns, columns + 1})
            for (const double r : {rows - 1, rows, rows + 1})
                if (c * r > 0) nearest = std::min(nearest, std::abs(c * r - wanted));
        const auto places = jittered_lattice(two_by_one, wanted / 2.0, 0, most_places, halfway);
        EXPECT_EQ(std::abs(static_cast<double>(places.size()) - wanted), nearest) << wanted;
    }
}

TEST(JitteredLattice, MovesEachPlaceWithinItsCell) {
    const auto still = jittered_lattice(square_cm, 100, 0.8, most_places, halfway);
    const auto moved = jittered_lattice(square_cm, 100, 0.8, most_places, scattered);
    ASSERT_EQ(still.size(), 100U);
    ASSERT_EQ(moved.size(), 100U);
    EXPECT_EQ(still[0], (Position{-4.5, -4.5}));
    double largest = 0;
    for (std::size_t i = 0; i < 100; ++i)
        largest = std::max(largest, std::abs(moved[i].x_mm - still[i].x_mm));
    EXPECT_LE(largest, 0.4);
    EXPECT_GT(largest, 0.35);
}

TEST(JitteredLattice, RefusesTooManyAfferents) {
    EXPECT_THROW(jittered_lattice(square_cm, 1e5, 0, 1000, halfway), ParameterError);
}

// A row is found by its number, and the nearest element without going through all.
TEST(ElementGrid, HasRows) {
    const ElementGrid grid({Outline::Shape::ellipse, 9, 6}, 0.7, 1000);
    std::uint32_t met = 0;
    for (std::uint32_t row = 0; row < grid.rows(); ++row) {
        EXPECT_EQ(grid.first_of_row(row), met);
        for (std::size_t i = 0; i < grid.row(row).size(); ++i) {
            const Position& place = grid.row(row)[i];
            ASSERT_LT(met, grid.elements());
            EXPECT_EQ(place, grid.place(met++));
            EXPECT_EQ(place.y_mm, grid.row_y_mm(row));
            if (i > 0) {
                EXPECT_NEAR(place.x_mm - grid.row(row)[i - 1].x_mm, 0.7, 1e-12);
            }
        }
    }
    EXPECT_EQ(met, grid.elements());
    // Fields that reach no element read the nearest.
    for (const Position& place :
         {Position{4.4, 0.9}, Position{-2.1, 2.9}, Position{0.1, -2.99}, Position{3.2, -2.2}}) {
        const auto field = gaussian_field(grid, place, 0.01);
        ASSERT_EQ(field.size(), 1U);
        double nearest = 1e9;
        for (std::uint32_t i = 0; i < grid.elements(); ++i)
            nearest = std::min(nearest,
                               std::hypot(grid.place(i).x_mm - place.x_mm, grid.place(i).y_mm - place.y_mm));
        const Position& found = grid.place(field[0].element);
        EXPECT_NEAR(std::hypot(found.x_mm - place.x_mm, found.y_mm - place.y_mm), nearest, 1e-12);
    }
}

}  // namespace
}  // namespace afferent
