// The outline of a patch. Included by scene headers.
#pragma once

#include <cmath>
#include <numbers>

#include "afferent/runtime/position.hpp"

namespace afferent {

// A rectangle or ellipse around the origin, with its axes along x and y.
struct Outline {
    enum class Shape { rectangle, ellipse };

    Shape shape = Shape::rectangle;
    double width_mm = 10;
    double height_mm = 10;

    double area_mm2() const noexcept {
        return width_mm * height_mm * (shape == Shape::ellipse ? std::numbers::pi / 4 : 1);
    }
    // True for places on the border, too.
    bool contains(const Position& place) const noexcept {
        const double x = 2 * place.x_mm / width_mm;
        const double y = 2 * place.y_mm / height_mm;
        return shape == Shape::ellipse ? x * x + y * y <= 1 : std::abs(x) <= 1 && std::abs(y) <= 1;
    }
};

}  // namespace afferent
