#include "afferent/hand/texture.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

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
// number of periods down a column.
std::vector<double> rough_heights(const Roughness& roughness) {
    using Complex = std::complex<double>;
    const std::size_t side = pixels_of(roughness);
    const double longest = longest_waves_a_side * roughness.longest_mm;
    const auto most = static_cast<std::int64_t>(longest / roughness.shortest_mm);
    std::vector<Complex> circle(side);
    for (std::size_t i = 0; i < side; ++i)
        circle[i] =
            std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(side));
    const auto wave = [&](std::int64_t periods, std::size_t at) {
        const auto n = static_cast<std::int64_t>(side);
        return circle[static_cast<std::size_t>(((periods * static_cast<std::int64_t>(at)) % n + n) % n)];
    };
    std::vector<Complex> rows(static_cast<std::size_t>(most + 1) * side);
    // A wave and its opposite are one: of every pair, that with more periods down, or along.
    for (std::int64_t down = 0; down <= most; ++down)
        for (std::int64_t along = down > 0 ? -most : 1; along <= most; ++along) {
            const double periods = std::hypot(down, along);
            if (periods < longest_waves_a_side || periods > static_cast<double>(most)) continue;
            const auto index = static_cast<std::uint64_t>(down * (2 * most + 1) + along + most);
            const double phase =
                2 * std::numbers::pi * uniform(roughness.seed, Stream::texture_phase, 0, index);
            const Complex amplitude = std::polar(std::pow(periods, -1 - roughness.hurst), phase);
            for (std::size_t x = 0; x < side; ++x)
                rows[static_cast<std::size_t>(down) * side + x] += amplitude * wave(along, x);
        }
    std::vector<double> heights(side * side);
    for (std::int64_t down = 0; down <= most; ++down)
        for (std::size_t y = 0; y < side; ++y) {
            const Complex turn = wave(down, y);
            for (std::size_t x = 0; x < side; ++x)
                heights[y * side + x] += (rows[static_cast<std::size_t>(down) * side + x] * turn).real();
        }
    double squares = 0;
    for (const double height : heights) squares += height * height;
    const double scale = roughness.rms_mm / std::sqrt(squares / static_cast<double>(heights.size()));
    for (double& height : heights) height *= scale;
    return heights;
}

}  // namespace

Texture::Texture(std::vector<double> heights_mm, std::size_t side, double pixel_mm)
    : side_(side), pixel_mm_(pixel_mm), sums_((side + 1) * (side + 1)) {
    const double mean =
        std::accumulate(heights_mm.begin(), heights_mm.end(), 0.0) / static_cast<double>(heights_mm.size());
    for (std::size_t y = 0; y < side; ++y) {
        double row = 0;
        for (std::size_t x = 0; x < side; ++x) {
            row += heights_mm[y * side + x] - mean;
            sums_[(y + 1) * (side + 1) + x + 1] = sums_[y * (side + 1) + x + 1] + row;
        }
    }
}

Texture::Texture(const Roughness& roughness)
    : Texture(rough_heights(roughness), pixels_of(roughness),
              longest_waves_a_side * roughness.longest_mm / static_cast<double>(pixels_of(roughness))) {}

double Texture::integral(double u, double v) const noexcept {
    const auto side = static_cast<double>(side_);
    const double u_repeats = std::floor(u / side);
    const double v_repeats = std::floor(v / side);
    u -= u_repeats * side;
    v -= v_repeats * side;
    // Within a pixel the height is constant, so that the integral is bilinear.
    const auto column = std::min(static_cast<std::size_t>(u), side_ - 1);
    const auto row = std::min(static_cast<std::size_t>(v), side_ - 1);
    const double right = u - static_cast<double>(column);
    const double up = v - static_cast<double>(row);
    const auto between = [&](std::size_t y) {
        const double* sums = &sums_[y * (side_ + 1)];
        return std::lerp(sums[column], sums[column + 1], right);
    };
    const double part = std::lerp(between(row), between(row + 1), up);
    if (u_repeats == 0 && v_repeats == 0) return part;
    // The whole square adds up to 0. Whole rows of a repeat, and whole columns, do not.
    const auto at_end = [&](std::size_t index) { return sums_[index * (side_ + 1) + side_]; };
    const double rows = std::lerp(at_end(row), at_end(row + 1), up);
    const double columns =
        std::lerp(sums_[side_ * (side_ + 1) + column], sums_[side_ * (side_ + 1) + column + 1], right);
    return part + u_repeats * rows + v_repeats * columns;
}

double Texture::mean_height_mm(double u_mm, double v_mm, double width_mm) const noexcept {
    const auto within = [&](double mm) { return mm - std::floor(mm / side_mm()) * side_mm(); };
    const double left = within(u_mm - width_mm / 2) / pixel_mm_;
    const double low = within(v_mm - width_mm / 2) / pixel_mm_;
    const double width = width_mm / pixel_mm_;
    return (integral(left + width, low + width) - integral(left, low + width) - integral(left + width, low) +
            integral(left, low)) /
           (width * width);
}

}  // namespace afferent
