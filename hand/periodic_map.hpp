// A function of a place on a plane that repeats itself in squares.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "afferent/hand/smooth_table.hpp"

namespace afferent {

// Cubic B-splines through pixels, with continuous second derivatives.
class PeriodicMap {
  public:
    // The coefficients of the splines, row by row, of a square of side_mm.
    PeriodicMap(double side_mm, std::vector<double> coefficients)
        : side_(static_cast<std::size_t>(std::lround(std::sqrt(coefficients.size())))),
          pixel_mm_(side_mm / static_cast<double>(side_)),
          coefficients_(std::move(coefficients)) {}

    // The spline whose coefficients are a wave with so many periods a side is that wave times this factor at
    // the pixels.
    static double at_pixels(std::int64_t periods, std::size_t side) noexcept {
        const double turn = 2 * std::numbers::pi * static_cast<double>(periods) / static_cast<double>(side);
        return (2 + std::cos(turn)) / 3;
    }

    double side_mm() const noexcept { return static_cast<double>(side_) * pixel_mm_; }

    double operator()(double u_mm, double v_mm) const noexcept {
        const Pixels along(u_mm, pixel_mm_, side_);
        const Pixels down(v_mm, pixel_mm_, side_);
        double sum = 0;
        for (std::size_t j = 0; j < 4; ++j) {
            const double* const from = &coefficients_[down.index[j] * side_];
            double of_row = 0;
            for (std::size_t i = 0; i < 4; ++i) of_row += along.weights[i] * from[along.index[i]];
            sum += down.weights[j] * of_row;
        }
        return sum;
    }

  private:
    // The pixels whose coefficients count at a place on an axis, and their weights.
    struct Pixels {
        std::array<std::size_t, 4> index;
        std::array<double, 4> weights;

        Pixels(double mm, double pixel_mm, std::size_t side) noexcept {
            const double pixels = mm / pixel_mm;
            const double repeats = std::floor(pixels / static_cast<double>(side));
            const auto [first, fraction] = split(pixels - repeats * static_cast<double>(side), side - 1);
            weights = spline_weights(fraction);
            for (std::size_t i = 0; i < 4; ++i) index[i] = (first + side - 1 + i) % side;
        }
    };

    std::size_t side_;
    double pixel_mm_;
    std::vector<double> coefficients_;
};

}  // namespace afferent
