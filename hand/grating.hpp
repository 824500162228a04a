// A surface with ridges across the direction of sliding.
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/hand/sliding_surface.hpp"
#include "afferent/hand/smooth_table.hpp"

namespace afferent {

// Ridges of a width begin at every multiple of the period; between them the surface is lower by the depth.
class Grating {
  public:
    Grating(double period_mm, double ridge_mm, double depth_mm, const Aperture& aperture);

    double mean_kpa(double smooth_kpa, double u_mm, double, const Pad& pad) const noexcept {
        const double groove_kpa = std::max(0.0, smooth_kpa - pad.stiffness_kpa_per_mm * depth_mm_);
        return std::lerp(groove_kpa, smooth_kpa, ridge_around(u_mm));
    }

  private:
    // The part of the skin around u that is on a ridge.
    double ridge_around(double u_mm) const noexcept {
        const double from_ridge_mm = u_mm - ridge_mm_ / 2;
        return ridge_(from_ridge_mm - period_mm_ * std::round(from_ridge_mm / period_mm_));
    }

    double period_mm_;
    double ridge_mm_;
    double depth_mm_;
    EvenTable ridge_;  // by the distance from the middle of one
};

static_assert(Relief<Grating>);
static_assert(Stimulus<SlidingSurface<Grating>>);

}  // namespace afferent
