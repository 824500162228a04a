#include "afferent/hand/sliding_edge.hpp"

#include <numbers>

namespace afferent {
namespace {

constexpr double most_units = 64;  // of the aperture, in a half width

// What an element feels at a distance from an edge: the Fourier series, in units of the aperture and over a
// period that is twice as long as the edge and the aperture reach, of the transform of Hertz's pressure, π/2
// a · 2 J₁(qa)/(qa), times that of the aperture.
EvenTable profile_n(double half_width_mm, double peak_kpa, const Aperture& aperture) {
    const double unit_mm = aperture.unit_mm(half_width_mm, most_units);
    const double a = half_width_mm / unit_mm;
    const double reach = a + Aperture::reach;
    const double half_period = reach + 4 / Aperture::steps_a_unit;
    const double force_n = std::numbers::pi / 2 * a * peak_kpa * aperture.n_per_kpa();
    std::vector<double> amplitudes{force_n / (2 * half_period)};
    const auto wave_number = [&](std::size_t n) {
        return static_cast<double>(n) * std::numbers::pi / half_period;
    };
    for (std::size_t n = 1; wave_number(n) < Aperture::most_radians; ++n) {
        const double q = wave_number(n);
        amplitudes.push_back(force_n / half_period * 2 * std::cyl_bessel_j(1, q * a) / (q * a) *
                             Aperture::transform(q));
    }
    return {unit_mm / Aperture::steps_a_unit, reach * unit_mm, [&](std::ptrdiff_t i) {
                double sum = 0;
                for (std::size_t n = 0; n < amplitudes.size(); ++n)
                    sum += amplitudes[n] *
                           std::cos(wave_number(n) * static_cast<double>(i) / Aperture::steps_a_unit);
                return sum;
            }};
}

}  // namespace

SlidingEdge::SlidingEdge(const Parameters& parameters, const Aperture& aperture)
    : parameters_(parameters),
      heading_(Heading::of_degrees(parameters.direction_deg)),
      reach_mm_(parameters.half_width_mm +
                Aperture::reach * aperture.unit_mm(parameters.half_width_mm, most_units)),
      force_at_(profile_n(parameters.half_width_mm, parameters.peak_kpa, aperture)) {}

}  // namespace afferent
