// A rough surface: a map of heights that repeats itself.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "afferent/hand/sliding_surface.hpp"

namespace afferent {

class Texture {
  public:
    // A square of four of the longest waves. longest_mm is at most 32 times shortest_mm.
    Texture(const Roughness& roughness, const Aperture& aperture);

    double side_mm() const noexcept { return static_cast<double>(side_) * pixel_mm_; }
    // The height around a place of the surface, as an element feels it.
    double mean_height_mm(double u_mm, double v_mm) const noexcept;

    // Where the mean height lifts the skin off, the pressure is 0.
    double mean_kpa(double smooth_kpa, double u_mm, double v_mm, const Pad& pad) const noexcept {
        return std::max(0.0, smooth_kpa + pad.stiffness_kpa_per_mm * mean_height_mm(u_mm, v_mm));
    }

  private:
    std::size_t side_;
    double pixel_mm_;
    std::vector<double> coefficients_;  // of cubic splines through the mean heights around pixels, row by row
};

static_assert(Relief<Texture>);
static_assert(Stimulus<SlidingSurface<Texture>>);

}  // namespace afferent
