// A rough surface: a map of heights that repeats itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "afferent/hand/sliding_surface.hpp"

namespace afferent {

class Texture {
  public:
    // A square with that many pixels a side; heights row by row, and their mean counts as 0.
    Texture(std::vector<double> heights_mm, std::size_t side, double pixel_mm);
    // A square of four of the longest waves. longest_mm is at most 32 times shortest_mm.
    explicit Texture(const Roughness& roughness);

    double side_mm() const noexcept { return static_cast<double>(side_) * pixel_mm_; }
    // Of a square of the surface around a place, in closed form over the pixels and parts of them.
    double mean_height_mm(double u_mm, double v_mm, double width_mm) const noexcept;

    // Where the mean height lifts the skin off, the pressure is 0.
    double mean_kpa(double smooth_kpa, double u_mm, double v_mm, double width_mm,
                    const Pad& pad) const noexcept {
        return std::max(0.0, smooth_kpa + pad.stiffness_kpa_per_mm * mean_height_mm(u_mm, v_mm, width_mm));
    }

  private:
    // The integral of the heights from 0, in pixels, over any number of repeats; fastest within the first.
    double integral(double u, double v) const noexcept;

    std::size_t side_;
    double pixel_mm_;
    std::vector<double> sums_;  // of all heights before a row and column; side + 1 of either
};

static_assert(Relief<Texture>);
static_assert(Stimulus<SlidingSurface<Texture>>);

}  // namespace afferent
