#include "afferent/hand/dots.hpp"

#include <numbers>

namespace afferent {
namespace {

// The Fourier series of the dots, of which an element feels what its aperture leaves: that of one dot of
// radius a for the wave vector k is π a² · 2 J₁(|k| a) / (|k| a). It is even along both axes, so that it has
// cosines only, and is summed first along a row for each number of periods down a column.
std::vector<double> coefficients_of(double spacing_mm, double diameter_mm, const Aperture& aperture) {
    constexpr double most_units = 64;
    const double unit_mm = aperture.unit_mm(spacing_mm, most_units);
    const double wave_number = 2 * std::numbers::pi * unit_mm / spacing_mm;  // in radians a unit
    const auto most = static_cast<std::size_t>(Aperture::most_radians / wave_number);
    // At least four pixels for the shortest wave.
    const std::size_t side = std::max<std::size_t>(
        4 * most + 4, static_cast<std::size_t>(std::ceil(Aperture::steps_a_unit * spacing_mm / unit_mm)));
    const double radius = diameter_mm / 2 / unit_mm;
    const double covered = std::numbers::pi * std::pow(diameter_mm / 2 / spacing_mm, 2);
    std::vector<double> cosines(side);
    for (std::size_t i = 0; i < side; ++i)
        cosines[i] = std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(side));
    std::vector<double> coefficients(side * side);
    std::vector<double> row(side);
    for (std::size_t down = 0; down <= most; ++down) {
        std::fill(row.begin(), row.end(), 0.0);
        for (std::size_t along = 0; along <= most; ++along) {
            const double q = wave_number * std::hypot(down, along);
            if (q > Aperture::most_radians) break;
            const double dot = q == 0 ? 1 : 2 * std::cyl_bessel_j(1, q * radius) / (q * radius);
            const int alike = (down > 0 ? 2 : 1) * (along > 0 ? 2 : 1);
            const auto at_pixels = [&](std::size_t periods) {
                return PeriodicMap::at_pixels(static_cast<std::int64_t>(periods), side);
            };
            const double amplitude =
                covered * dot * Aperture::transform(q) * alike / (at_pixels(down) * at_pixels(along));
            for (std::size_t x = 0; x < side; ++x) row[x] += amplitude * cosines[along * x % side];
        }
        for (std::size_t y = 0; y < side; ++y)
            for (std::size_t x = 0; x < side; ++x)
                coefficients[y * side + x] += row[x] * cosines[down * y % side];
    }
    return coefficients;
}

}  // namespace

Dots::Dots(double spacing_mm, double diameter_mm, double depth_mm, const Aperture& aperture)
    : depth_mm_(depth_mm), on_dots_(spacing_mm, coefficients_of(spacing_mm, diameter_mm, aperture)) {}

}  // namespace afferent
