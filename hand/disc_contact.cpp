#include "afferent/hand/disc_contact.hpp"

#include <cstdint>
#include <numbers>
#include <vector>

#include "afferent/hand/smooth_table.hpp"

namespace afferent {
namespace {

using Tip = DiscContact::Tip;

constexpr double largest_distance = DiscContact::most_units + Aperture::reach;
// Beyond all that the table and its splines ask for.
constexpr double end = largest_distance + 0.75;

// The Fourier transform of the pressure of a load of 1 on a disc of radius 1.
double disc_transform(Tip tip, double q) {
    return tip == Tip::flat ? std::sph_bessel(0, q) : q == 0 ? 1 : 3 * std::sph_bessel(1, q) / q;
}

// The n-th positive zero of J₀, by McMahon's expansion and a step of Newton's.
double zero_of_j0(unsigned n) {
    const double beta = (n - 0.25) * std::numbers::pi;
    const double zero = beta + 1 / (8 * beta) - 124 / (3 * std::pow(8 * beta, 3));
    return zero + std::cyl_bessel_j(0, zero) / std::cyl_bessel_j(1, zero);
}

// The part that an element feels, by distance and radius. What is 0 from a distance L on is the
// Fourier-Bessel series
//
//     Σ F(q) J₀(qr) / (π L² J₁(qL)²)        over the zeros qL of J₀
//
// of its Fourier transform F, here that of the pressure times that of the aperture.
class Parts {
  public:
    explicit Parts(Tip tip)
        : columns_(steps(largest_distance) + 3),
          coefficients_(columns_ * (steps(DiscContact::most_units) + 3)) {
        for (unsigned n = 1;; ++n) {
            const double zero = zero_of_j0(n);
            const double q = zero / end;
            if (q > Aperture::most_radians) break;
            const double j1 = std::cyl_bessel_j(1, zero);
            const double amplitude = Aperture::transform(q) / (std::numbers::pi * end * end * j1 * j1);
            const std::vector<double> of_distance =
                coefficients(columns_, [&](double units) { return std::cyl_bessel_j(0, q * units); });
            const std::vector<double> of_radius =
                coefficients(coefficients_.size() / columns_,
                             [&](double units) { return disc_transform(tip, q * units); });
            for (std::size_t row = 0; row < of_radius.size(); ++row)
                for (std::size_t k = 0; k < columns_; ++k)
                    coefficients_[row * columns_ + k] += amplitude * of_radius[row] * of_distance[k];
        }
    }

    double operator()(double distance, double radius) const noexcept {
        const auto [column, along] = split(distance * Aperture::steps_a_unit, columns_ - 4);
        const auto [row, down] = split(radius * Aperture::steps_a_unit, coefficients_.size() / columns_ - 4);
        const auto of_columns = spline_weights(along);
        const auto of_rows = spline_weights(down);
        double sum = 0;
        for (std::size_t j = 0; j < 4; ++j) {
            const double* const from = &coefficients_[(row + j) * columns_ + column];
            double of_row = 0;
            for (std::size_t i = 0; i < 4; ++i) of_row += of_columns[i] * from[i];
            sum += of_rows[j] * of_row;
        }
        return sum;
    }

  private:
    static std::size_t steps(double units) {
        return static_cast<std::size_t>(Aperture::steps_a_unit * units);
    }
    // From that of −1 step on, of an even function.
    template <class F>
    static std::vector<double> coefficients(std::size_t count, const F& value) {
        std::vector<double> values(count + 3);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = value(static_cast<double>(i) / Aperture::steps_a_unit);
        std::vector<double> all(count);
        for (std::size_t i = 0; i < count; ++i)
            all[i] = spline_coefficient(
                [&](std::ptrdiff_t k) { return values[static_cast<std::size_t>(std::abs(k))]; },
                static_cast<std::ptrdiff_t>(i) - 1);
        return all;
    }

    std::size_t columns_;
    std::vector<double> coefficients_;  // by radius and distance, from those of −1 step on
};

const Parts& parts(Tip tip) {
    if (tip == Tip::flat) {
        static const Parts flat(Tip::flat);
        return flat;
    }
    static const Parts sphere(Tip::sphere);
    return sphere;
}

}  // namespace

void DiscContact::make_table(Tip tip) { parts(tip); }

double DiscContact::part(Tip tip, double distance, double radius) noexcept {
    return std::max(0.0, parts(tip)(distance, radius));  // not below by rounding
}

}  // namespace afferent
