// Functions from tables, with continuous second derivatives: cubic B-splines on equal steps.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace afferent {

// The weights of the coefficients i − 1 to i + 2 at a fraction of the way from step i to the next.
inline std::array<double, 4> spline_weights(double fraction) noexcept {
    const double f = fraction;
    const double left = 1 - f;
    return {left * left * left / 6, (4 - f * f * (6 - 3 * f)) / 6, (4 - left * left * (6 - 3 * left)) / 6,
            f * f * f / 6};
}

// The coefficient of step i of a function value(i) that is smooth over some three steps: the inverse of the
// spline's own smoothing, without its derivatives from the sixth on.
template <class F>
double spline_coefficient(const F& value, std::ptrdiff_t i) {
    return 1.5 * value(i) - 5.0 / 18 * (value(i - 1) + value(i + 1)) +
           1.0 / 36 * (value(i - 2) + value(i + 2));
}

// A step of a table, and the fraction of the way to the next.
inline std::pair<std::size_t, double> split(double steps, std::size_t last) noexcept {
    const auto i = std::min(static_cast<std::size_t>(steps), last);
    return {i, steps - static_cast<double>(i)};
}

// An even function of x up to a largest |x|, and that value beyond it.
class EvenTable {
  public:
    // value(i) is that at i steps, for i from −3 to a little more than largest/step.
    template <class F>
    EvenTable(double step, double largest, const F& value)
        : step_(step),
          largest_(largest),
          coefficients_(static_cast<std::size_t>(std::ceil(largest / step)) + 3) {
        for (std::size_t i = 0; i < coefficients_.size(); ++i)
            coefficients_[i] = spline_coefficient(value, static_cast<std::ptrdiff_t>(i) - 1);
    }

    double operator()(double x) const noexcept {
        const auto [i, fraction] = split(std::min(std::abs(x), largest_) / step_, coefficients_.size() - 4);
        const auto weights = spline_weights(fraction);
        double sum = 0;
        for (std::size_t k = 0; k < 4; ++k) sum += weights[k] * coefficients_[i + k];
        return sum;
    }

  private:
    double step_;
    double largest_;
    std::vector<double> coefficients_;  // from that of −1 step on
};

}  // namespace afferent
