// A surface that slides under a pad of skin: a grating, dots, or a texture.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>

#include "afferent/hand/aperture.hpp"
#include "afferent/hand/stimulus.hpp"

namespace afferent {

// The shape of a surface. mean_kpa(smooth_kpa, u_mm, v_mm, pad) is the pressure that an element feels at a
// place of the surface, u along and v across the direction of sliding, where a smooth surface would have
// smooth_kpa.
template <class R>
concept Relief = requires(const R& relief, double kpa, double mm, const Pad& pad) {
    { relief.mean_kpa(kpa, mm, mm, pad) } -> std::same_as<double>;
};

// The surface and the pad at one time. The smooth pressure on an element is that at its place.
template <Relief R>
struct PressedSurface {
    const R* relief;
    Pad pad;
    Heading heading;
    double way_mm;  // of the surface
    double load;
    Aperture aperture;

    // Only elements on the pad count. A pad without pressure touches nothing, however rough the surface is.
    Stretch rows() const noexcept {
        const double reach_mm = pad.peak_kpa > 0 ? pad.height_mm / 2 * std::sqrt(std::max(0.0, load)) : 0;
        return {pad.y_mm - reach_mm, pad.y_mm + reach_mm};
    }
    Stretch columns(double y_mm) const noexcept {
        const double v = 2 * (y_mm - pad.y_mm) / pad.height_mm;
        const double reach_mm = pad.width_mm / 2 * std::sqrt(std::max(0.0, load - v * v));
        return {pad.x_mm - reach_mm, pad.x_mm + reach_mm};
    }
    double force_n(const Position& place) const noexcept {
        const double x = place.x_mm - pad.x_mm;
        const double y = place.y_mm - pad.y_mm;
        return relief->mean_kpa(pad.smooth_kpa(place.x_mm, place.y_mm, load), heading.along(x, y) - way_mm,
                                heading.across(x, y), pad) *
               aperture.n_per_kpa();
    }
};

template <Relief R>
class SlidingSurface {
  public:
    // The relief is felt through the same aperture.
    SlidingSurface(R relief, const Pad& pad, double direction_deg, double speed_mm_per_s, const Press& press,
                   const Aperture& aperture)
        : relief_(std::move(relief)),
          pad_(pad),
          heading_(Heading::of_degrees(direction_deg)),
          speed_mm_per_s_(speed_mm_per_s),
          press_(press),
          aperture_(aperture) {}

    // Valid as long as the surface is.
    PressedSurface<R> at(TimePoint time) const noexcept {
        return {&relief_, pad_, heading_, speed_mm_per_s_ * press_.since(time), press_.at(time), aperture_};
    }

  private:
    R relief_;
    Pad pad_;
    Heading heading_;
    double speed_mm_per_s_;
    Press press_;
    Aperture aperture_;
};

}  // namespace afferent
