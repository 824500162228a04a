// A surface with ridges across the direction of sliding.
#pragma once

#include <algorithm>
#include <cmath>

#include "afferent/hand/sliding_surface.hpp"

namespace afferent {

// Ridges of a width begin at every multiple of the period; between them the surface is lower by the depth.
struct Grating {
    double period_mm = 2;
    double ridge_mm = 1;
    double depth_mm = 0.5;
    bool operator==(const Grating&) const = default;

    double mean_kpa(double smooth_kpa, double u_mm, double, double width_mm, const Pad& pad) const noexcept {
        const double ridge = (ridge_until(u_mm + width_mm / 2) - ridge_until(u_mm - width_mm / 2)) / width_mm;
        const double groove_kpa = std::max(0.0, smooth_kpa - pad.stiffness_kpa_per_mm * depth_mm);
        return ridge * smooth_kpa + (1 - ridge) * groove_kpa;
    }

  private:
    // How much of the way from 0 to u is ridge.
    double ridge_until(double u_mm) const noexcept {
        const double periods = std::floor(u_mm / period_mm);
        return periods * ridge_mm + std::min(ridge_mm, u_mm - periods * period_mm);
    }
};

static_assert(Relief<Grating>);
static_assert(Stimulus<SlidingSurface<Grating>>);

}  // namespace afferent
