#include "afferent/hand/aperture.hpp"

#include <cmath>

namespace afferent {
namespace {

// i₂(z)/z² of z², and j₂(y)/y² where z² = −y² is negative.
double shape(double square) noexcept {
    if (std::abs(square) < 1e-2) return (1 + square / 14 + square * square / 504) / 15;
    if (square < 0) {
        const double y = std::sqrt(-square);
        return ((3 + square) * std::sin(y) - 3 * y * std::cos(y)) / (square * square * y);
    }
    const double z = std::sqrt(square);
    return ((3 + square) * std::sinh(z) - 3 * z * std::cosh(z)) / (square * square * z);
}

// The first zero of the transform, where (qR)² − α² = 5.763², lies at 0.97 of the grid's wave number, so that
// the waves around that are small, too.
constexpr double alpha_square = 199;

}  // namespace

double Aperture::transform(double radians) noexcept {
    static const double whole = shape(alpha_square);
    const double x = radians * reach;
    return shape(alpha_square - x * x) / whole;
}

}  // namespace afferent
