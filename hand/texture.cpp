#include "afferent/hand/texture.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "afferent/hand/random.hpp"

namespace afferent {
namespace {

constexpr double longest_waves_a_side = 4;
constexpr double pixels_a_wave = 4;  // of the shortest

std::size_t pixels_of(const Roughness& roughness) {
    return static_cast<std::size_t>(
        std::ceil(pixels_a_wave * longest_waves_a_side * roughness.longest_mm / roughness.shortest_mm));
}

// The heights are a sum of waves with whole numbers of periods a side, first summed along a row for each
// number of periods down a column. The aperture leaves a part of each.
std::vector<double> coefficients_of(const Roughness& roughness, const Aperture& aperture) {
    using Complex = std::complex<double>;
    const std::size_t side = pixels_of(roughness);
    const double side_mm = longest_waves_a_side * roughness.longest_mm;
    const auto most = static_cast<std::int64_t>(side_mm / roughness.shortest_mm);
    std::vector<Complex> circle(side);
    for (std::size_t i = 0; i < side; ++i)
        circle[i] =
            std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(side));
    const auto wave = [&](std::int64_t periods, std::size_t at) {
        const auto n = static_cast<std::int64_t>(side);
        return circle[static_cast<std::size_t>(((periods * static_cast<std::int64_t>(at)) % n + n) % n)];
    };
    std::vector<Complex> rows(static_cast<std::size_t>(most + 1) * side);
    double squares = 0;  // of the amplitudes
    // A wave and its opposite are one: of every pair, that with more periods down, or along.
    for (std::int64_t down = 0; down <= most; ++down)
        for (std::int64_t along = down > 0 ? -most : 1; along <= most; ++along) {
            const double periods = std::hypot(down, along);
            if (periods < longest_waves_a_side || periods > static_cast<double>(most)) continue;
            const auto index = static_cast<std::uint64_t>(down * (2 * most + 1) + along + most);
            const double phase =
                2 * std::numbers::pi * uniform(roughness.seed, Stream::texture_phase, 0, index);
            const double height = std::pow(periods, -1 - roughness.hurst);
            squares += height * height;
            const double felt =
                Aperture::transform(2 * std::numbers::pi * periods * aperture.pitch_mm() / side_mm);
            // Where an aperture turns a wave over, the factor is negative, which polar() does not take.
            const Complex amplitude =
                height * felt / (PeriodicMap::at_pixels(down, side) * PeriodicMap::at_pixels(along, side)) *
                std::polar(1.0, phase);
            for (std::size_t x = 0; x < side; ++x)
                rows[static_cast<std::size_t>(down) * side + x] += amplitude * wave(along, x);
        }
    std::vector<double> coefficients(side * side);
    // The mean square of a wave is half that of its amplitude.
    const double scale = roughness.rms_mm / std::sqrt(squares / 2);
    for (std::int64_t down = 0; down <= most; ++down)
        for (std::size_t y = 0; y < side; ++y) {
            const Complex turn = scale * wave(down, y);
            for (std::size_t x = 0; x < side; ++x)
                coefficients[y * side + x] += (rows[static_cast<std::size_t>(down) * side + x] * turn).real();
        }
    return coefficients;
}

}  // namespace

Texture::Texture(const Roughness& roughness, const Aperture& aperture)
    : mean_heights_mm_(longest_waves_a_side * roughness.longest_mm, coefficients_of(roughness, aperture)) {}

}  // namespace afferent
