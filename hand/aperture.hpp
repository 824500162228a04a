// How an element of skin feels the pressure around it.
#pragma once

#include <algorithm>

namespace afferent {

// An element is a point of a square grid, and feels the pressure p under a round kernel K as the force
//
//     pitch² ∫ p(x) K(|x − element|) dx
//
// Were that the force on a square cell, it would have a corner in time whenever an edge slides across a
// cell's border, and afferents that respond to its second derivative would fire in bars of the grid. K is
// smooth: a Kaiser-Bessel function (Lewitt 1990, J Opt Soc Am A 7:1834), which ends at a radius R of 2.5
// pitches, and whose Fourier transform
//
//     g(α² − (qR)²) / g(α²)        g(z²) = i₂(z) / z², with the modified spherical Bessel function i₂
//
// is so small from the wave number of the grid on, 2π/pitch, that sums over the elements do not show where
// these lie: they add up to the force of a point to 7e-5 of it, and of wider contacts more exactly.
class Aperture {
  public:
    // In pitches: R, and the standard deviation along either axis.
    static constexpr double reach = 2.5;
    static constexpr double sd = 0.5966;

    // The Fourier transform: how much is left of a wave of so many radians a pitch.
    static double transform(double radians) noexcept;
    // From these on it is below 1e-7.
    static constexpr double most_radians = 16;

    explicit Aperture(double pitch_mm) noexcept : pitch_mm_(pitch_mm) {}

    double pitch_mm() const noexcept { return pitch_mm_; }
    // The unit of K for what reaches so far from its middle: the pitch, or, where that is over most_units of
    // it, as much more as keeps tables small.
    double unit_mm(double extent_mm, double most_units) const noexcept {
        return std::max(pitch_mm_, extent_mm / most_units);
    }
    // Cubic splines on so many steps a unit are within 1e-5 of what is felt through K.
    static constexpr double steps_a_unit = 8;
    // The force of one kilopascal.
    double n_per_kpa() const noexcept { return 1e-3 * pitch_mm_ * pitch_mm_; }

  private:
    double pitch_mm_;
};

}  // namespace afferent
