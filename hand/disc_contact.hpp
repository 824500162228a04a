// Circular contacts with an elastic half-space.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/hand/stimulus.hpp"

namespace afferent {

// A force F on a disc of radius a, as a pressure at the distance r from its middle (Johnson, Contact
// Mechanics, 1985, chapters 3 and 4):
//
//     flat punch      F / (2π a √(a² − r²))              F = 2 a E* d
//     sphere (Hertz)  3F / (2π a³) √(a² − r²)            F = 4/3 E* √R d^(3/2),  a³ = 3FR / (4E*)
//
// at an indentation d, for a sphere of radius R. Both integrate in closed form over a rectangle.
struct DiscContact {
    using Tip = IndenterTip;

    Tip tip = Tip::flat;
    double x_mm = 0;  // its middle
    double y_mm = 0;
    double radius_mm = 1;  // of the disc
    double load_n = 0;

    // The radius of the disc on which a sphere bears a force.
    static double sphere_disc_mm(double force_n, double sphere_mm, const ElasticSkin& skin) noexcept {
        return std::cbrt(0.75 * force_n * sphere_mm / skin.contact_modulus_n_per_mm2());
    }
    // The forces at an indentation.
    static double flat_n(double depth_mm, double radius_mm, const ElasticSkin& skin) noexcept {
        return 2 * radius_mm * skin.contact_modulus_n_per_mm2() * depth_mm;
    }
    static double sphere_n(double depth_mm, double sphere_mm, const ElasticSkin& skin) noexcept {
        return 4.0 / 3 * skin.contact_modulus_n_per_mm2() * std::sqrt(sphere_mm) * depth_mm *
               std::sqrt(depth_mm);
    }

    double force_n(const SkinCell& cell) const noexcept {
        const double half_mm = cell.width_mm / 2;
        const double left = (cell.x_mm - half_mm - x_mm) / radius_mm;
        const double right = (cell.x_mm + half_mm - x_mm) / radius_mm;
        const double low = (cell.y_mm - half_mm - y_mm) / radius_mm;
        const double high = (cell.y_mm + half_mm - y_mm) / radius_mm;
        const double part = corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low);
        return load_n * std::max(0.0, part);  // not below by rounding
    }

    Stretch rows(double width_mm) const noexcept {
        if (load_n <= 0) return {0, 0};
        const double reach_mm = radius_mm + width_mm / 2;
        return {y_mm - reach_mm, y_mm + reach_mm};
    }
    Stretch columns(double row_mm, double width_mm) const noexcept {
        const double nearest_mm = std::max(0.0, std::abs(row_mm - y_mm) - width_mm / 2);
        if (nearest_mm >= radius_mm) return {0, 0};
        const double reach_mm = std::sqrt(radius_mm * radius_mm - nearest_mm * nearest_mm) + width_mm / 2;
        return {x_mm - reach_mm, x_mm + reach_mm};
    }

  private:
    // The part of the force on the rectangle between the middle and x, y (in radii; odd in both), with
    // z = √(1 − x² − y²), which is 0 beyond the disc:
    //
    //     flat     (x atan(y/z) + y atan(x/z) − atan(xy/z)) / 2π
    //     sphere   (xyz/3 + x (3 − x²)/6 atan(y/z) + y (3 − y²)/6 atan(x/z) − atan(xy/z)/3) · 3/2π
    double corner(double x, double y) const noexcept {
        x = std::clamp(x, -1.0, 1.0);
        y = std::clamp(y, -1.0, 1.0);
        const double z = std::sqrt(std::max(0.0, 1 - x * x - y * y));
        const double of_x = std::atan2(x, z);
        const double of_y = std::atan2(y, z);
        const double of_both = std::atan2(x * y, z);
        if (tip == Tip::flat) return (x * of_y + y * of_x - of_both) / (2 * std::numbers::pi);
        return (x * y * z + x * (3 - x * x) / 2 * of_y + y * (3 - y * y) / 2 * of_x - of_both) /
               (2 * std::numbers::pi);
    }
};

static_assert(Pressure<DiscContact>);

}  // namespace afferent
