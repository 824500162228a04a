// The contact of a rounded edge with an elastic half-space.
#pragma once

#include <algorithm>
#include <cmath>

namespace afferent {

// Hertz's line contact: the pressure  p(u) = peak · √(1 − (u/a)²)  at a distance u from the middle, and 0
// beyond a, the half width. Its integral up to u is  peak · a/2 · (asin(u/a) + u/a · √(1 − (u/a)²)) + a
// constant.
class EdgeContact {
  public:
    // Both > 0, or a peak of 0.
    EdgeContact(double half_width_mm, double peak_kpa) noexcept : a_mm_(half_width_mm), peak_kpa_(peak_kpa) {}

    // The force on a strip between two distances, as long as it is wide in the direction of the edge.
    double strip_n(double from_mm, double to_mm) const noexcept {
        constexpr double n_per_mm2 = 1e-3;  // of a kilopascal
        return peak_kpa_ * n_per_mm2 * a_mm_ / 2 * (integral(to_mm / a_mm_) - integral(from_mm / a_mm_)) *
               (to_mm - from_mm);
    }

    // Strips of that width feel the edge when their middles are closer to its own than this.
    double reach_mm(double width_mm) const noexcept { return a_mm_ + width_mm / 2; }

  private:
    static double integral(double u) noexcept {
        u = std::clamp(u, -1.0, 1.0);
        return std::asin(u) + u * std::sqrt(1 - u * u);
    }

    double a_mm_;
    double peak_kpa_;
};

}  // namespace afferent
