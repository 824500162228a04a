#include "afferent/hand/texture.hpp"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "afferent/hand/random.hpp"
#include "afferent/hand/smooth_table.hpp"

namespace afferent {
namespace {

constexpr double longest_waves_a_side = 4;
constexpr double pixels_a_wave = 4;  // of the shortest

std::size_t pixels_of(const Roughness& roughness) {
    return static_cast<std::size_t>(
        std::ceil(pixels_a_wave * longest_waves_a_side * roughness.longest_mm / roughness.shortest_mm));
}

// By how much the spline through a wave is flatter at the pixels than its coefficients are.
double spline_at_pixels(std::int64_t periods, std::size_t side) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(periods) / static_cast<double>(side);
    return (2 + std::cos(turn)) / 3;
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
            const Complex amplitude = height * felt /
                                      (spline_at_pixels(down, side) * spline_at_pixels(along, side)) *
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

// The pixels whose coefficients count at a place on an axis, and their weights.
struct Pixels {
    std::array<std::size_t, 4> index;
    std::array<double, 4> weights;

    Pixels(double mm, double pixel_mm, std::size_t side) noexcept {
        const double pixels = mm / pixel_mm;
        const double repeats = std::floor(pixels / static_cast<double>(side));
        const auto [first, fraction] = split(pixels - repeats * static_cast<double>(side), side - 1);
        weights = spline_weights(fraction);
        for (std::size_t i = 0; i < 4; ++i) index[i] = (first + side - 1 + i) % side;
    }
};

}  // namespace

Texture::Texture(const Roughness& roughness, const Aperture& aperture)
    : side_(pixels_of(roughness)),
      pixel_mm_(longest_waves_a_side * roughness.longest_mm / static_cast<double>(side_)),
      coefficients_(coefficients_of(roughness, aperture)) {}

double Texture::mean_height_mm(double u_mm, double v_mm) const noexcept {
    const Pixels along(u_mm, pixel_mm_, side_);
    const Pixels down(v_mm, pixel_mm_, side_);
    double sum = 0;
    for (std::size_t j = 0; j < 4; ++j) {
        const double* const from = &coefficients_[down.index[j] * side_];
        double of_row = 0;
        for (std::size_t i = 0; i < 4; ++i) of_row += along.weights[i] * from[along.index[i]];
        sum += down.weights[j] * of_row;
    }
    return sum;
}

}  // namespace afferent
