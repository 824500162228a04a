// A rough surface: a map of heights that repeats itself.
#pragma once

#include <algorithm>

#include "afferent/hand/periodic_map.hpp"
#include "afferent/hand/sliding_surface.hpp"

namespace afferent {

class Texture {
  public:
    // A square of four of the longest waves. longest_mm is at most 32 times shortest_mm.
    Texture(const Roughness& roughness, const Aperture& aperture);

    double side_mm() const noexcept { return mean_heights_mm_.side_mm(); }
    // The height around a place of the surface, as an element feels it.
    double mean_height_mm(double u_mm, double v_mm) const noexcept { return mean_heights_mm_(u_mm, v_mm); }

    // Where the mean height lifts the skin off, the pressure is 0.
    double mean_kpa(double smooth_kpa, double u_mm, double v_mm, const Pad& pad) const noexcept {
        return std::max(0.0, smooth_kpa + pad.stiffness_kpa_per_mm * mean_height_mm(u_mm, v_mm));
    }

  private:
    PeriodicMap mean_heights_mm_;
};

static_assert(Relief<Texture>);
static_assert(Stimulus<SlidingSurface<Texture>>);

}  // namespace afferent
