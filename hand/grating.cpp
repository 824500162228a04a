#include "afferent/hand/grating.hpp"

#include <numbers>

namespace afferent {
namespace {

// The Fourier series of the ridges, of which an element feels what its aperture leaves.
EvenTable ridge_profile(double period_mm, double ridge_mm, const Aperture& aperture) {
    const double unit_mm = aperture.unit_mm(period_mm, 64);
    const double wave_number = 2 * std::numbers::pi * unit_mm / period_mm;  // in radians a unit
    return {unit_mm / Aperture::steps_a_unit, period_mm / 2, [=](std::ptrdiff_t i) {
                double sum = ridge_mm / period_mm;
                for (int n = 1; n * wave_number < Aperture::most_radians; ++n)
                    sum += 2 / (std::numbers::pi * n) *
                           std::sin(std::numbers::pi * n * ridge_mm / period_mm) *
                           Aperture::transform(n * wave_number) *
                           std::cos(n * wave_number * static_cast<double>(i) / Aperture::steps_a_unit);
                return sum;
            }};
}

}  // namespace

Grating::Grating(double period_mm, double ridge_mm, double depth_mm, const Aperture& aperture)
    : period_mm_(period_mm),
      ridge_mm_(ridge_mm),
      depth_mm_(depth_mm),
      ridge_(ridge_profile(period_mm, ridge_mm, aperture)) {}

}  // namespace afferent
