// A surface with raised dots in a square array, like the embossed dots by which the roughness of surfaces was
// studied (Connor et al. 1990, J Neurosci 10:3823).
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/hand/periodic_map.hpp"
#include "afferent/hand/sliding_surface.hpp"

namespace afferent {

// Round dots of a diameter, with flat tops, whose middles are a spacing apart along and across the direction
// of sliding; one is at the origin. Between them the surface is lower by the depth.
class Dots {
  public:
    Dots(double spacing_mm, double diameter_mm, double depth_mm, const Aperture& aperture);

    double mean_kpa(double smooth_kpa, double u_mm, double v_mm, const Pad& pad) const noexcept {
        const double between_kpa = std::max(0.0, smooth_kpa - pad.stiffness_kpa_per_mm * depth_mm_);
        return std::lerp(between_kpa, smooth_kpa, std::clamp(on_dots_(u_mm, v_mm), 0.0, 1.0));
    }

  private:
    double depth_mm_;
    PeriodicMap on_dots_;  // the part of the skin around a place that is on dots
};

static_assert(Relief<Dots>);
static_assert(Stimulus<SlidingSurface<Dots>>);

}  // namespace afferent
