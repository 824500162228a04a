// Circular contacts with an elastic half-space.
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/hand/aperture.hpp"
#include "afferent/hand/stimulus.hpp"

namespace afferent {

// A force F on a disc of radius a, as a pressure at the distance r from its middle (Johnson, Contact
// Mechanics, 1985, chapters 3 and 4):
//
//     flat punch      F / (2π a √(a² − r²))              F = 2 a E* d
//     sphere (Hertz)  3F / (2π a³) √(a² − r²)            F = 4/3 E* √R d^(3/2),  a³ = 3FR / (4E*)
//
// at an indentation d, for a sphere of radius R. An element feels a part of F that depends on its distance
// from the middle alone.
struct DiscContact {
    using Tip = IndenterTip;

    Tip tip = Tip::flat;
    double x_mm = 0;  // its middle
    double y_mm = 0;
    double radius_mm = 1;  // of the disc
    double load_n = 0;
    Aperture aperture;

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

    double force_n(const Position& place) const noexcept {
        const double distance_mm = std::hypot(place.x_mm - x_mm, place.y_mm - y_mm);
        if (distance_mm >= reach_mm()) return 0;
        const double unit_mm = this->unit_mm();
        const double pitch = aperture.pitch_mm() / unit_mm;
        return load_n * pitch * pitch * part(tip, distance_mm / unit_mm, radius_mm / unit_mm);
    }

    Stretch rows() const noexcept {
        return load_n > 0 ? Stretch{y_mm - reach_mm(), y_mm + reach_mm()} : Stretch{0, 0};
    }
    Stretch columns(double row_mm) const noexcept {
        const double square = reach_mm() * reach_mm() - (row_mm - y_mm) * (row_mm - y_mm);
        const double half_mm = std::sqrt(std::max(0.0, square));
        return {x_mm - half_mm, x_mm + half_mm};
    }

    // Makes the table of what elements feel, a few milliseconds' work, so that no force has to wait for it.
    static void make_table(Tip tip);

    static constexpr double most_units = 8;  // of the aperture, in a radius

  private:
    // What an element feels of a load of 1, by its distance and the disc's radius in units of the aperture.
    static double part(Tip tip, double distance, double radius) noexcept;

    double unit_mm() const noexcept { return aperture.unit_mm(radius_mm, most_units); }
    double reach_mm() const noexcept { return radius_mm + Aperture::reach * unit_mm(); }
};

static_assert(Pressure<DiscContact>);

}  // namespace afferent
