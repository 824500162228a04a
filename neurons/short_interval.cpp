#include "afferent/neurons/short_interval.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace afferent {
namespace {

constexpr auto reciprocals = [] {
    std::array<double, 33> values{};
    for (std::size_t n = 1; n < values.size(); ++n) values[n] = 1.0 / static_cast<double>(n);
    return values;
}();

}  // namespace

double ShortInterval::longest(double a, double g) noexcept { return std::min(2 / (1 + g), 0.28 * a); }

ShortInterval::ShortInterval(double a, double reversal_mv, double gap_mv, double g, double excess_mv,
                             double fall) noexcept
    : a_(a), x_(a * g), reversal_mv_(reversal_mv), excess_mv_(excess_mv), fall_(fall) {
    const double sum = a + x_;
    const double pull = fall * x_ * reversal_mv;
    const double push = fall * a * excess_mv;
    const double square = fall * fall * x_;
    terms_[0] = gap_mv;
    terms_[1] = fall * (sum * gap_mv) + (push - pull);
    terms_[2] = 0.5 * (fall * (sum - 1) * terms_[1] + square * (gap_mv - reversal_mv));
    terms_[3] = reciprocals[3] * (fall * (sum - 2) * terms_[2] + square * terms_[1]);
    end_mv_ = (terms_[0] + terms_[1]) + (terms_[2] + terms_[3]);
    // Negligible beside the contributions to z.
    const double unseen = 1e-17 * (std::abs(gap_mv) + std::abs(push) + std::abs(pull));
    std::size_t n = 3;
    while (n + 4 < most) {
        // Two at a time from the two before, so that the second does not wait for the first.
        for (int i = 0; i < 2; ++i, n += 2) {
            const double count = static_cast<double>(n);
            const double one = reciprocals[n + 1] * fall * (sum - count);
            const double other = reciprocals[n + 1] * square;
            const double next_one = reciprocals[n + 2] * fall * (sum - count - 1);
            const double next_other = reciprocals[n + 2] * square;
            terms_[n + 1] = one * terms_[n] + other * terms_[n - 1];
            terms_[n + 2] = (next_one * one + next_other) * terms_[n] + (next_one * other) * terms_[n - 1];
        }
        end_mv_ += (terms_[n - 3] + terms_[n - 2]) + (terms_[n - 1] + terms_[n]);
        // Two terms in a row, because the recurrence has two.
        if (std::abs(terms_[n]) + std::abs(terms_[n - 1]) <= unseen) {
            converged_ = true;
            break;
        }
    }
    count_ = static_cast<int>(n) + 1;
}

double ShortInterval::value(double part) const noexcept {
    // Four independent polynomials: in a single one every product would wait for the one before.
    const double square = part * part;
    const double fourth = square * square;
    double sums[4] = {};
    for (int n = count_ - 4; n >= 0; n -= 4)
        for (std::size_t i = 0; i < 4; ++i)
            sums[i] = sums[i] * fourth + terms_[static_cast<std::size_t>(n) + i];
    return (sums[0] + sums[1] * part) + square * (sums[2] + sums[3] * part);
}

// As a part of the interval, where z is 0 on the cubic that has its values and slopes at both ends, as a
// function of z. Not a number in [0, 1] where z is not monotonic.
double ShortInterval::guess() const noexcept {
    const double drop = terms_[0] - end_mv_;
    const double passed = terms_[0] / drop;
    const double left = end_mv_ / drop;  // not positive
    const double end_x = x_ * (1 + fall_);
    const double end_slope = (a_ + end_x) * end_mv_ - end_x * reversal_mv_ + a_ * excess_mv_;
    const double begin = drop / terms_[1];
    const double end = drop * (1 + fall_) / (fall_ * end_slope);
    return passed * passed * (3 - 2 * passed) - passed * left * (begin * left + end * passed);
}

// Halley's steps, kept within the bracket: the equation gives both derivatives with the value.
double ShortInterval::root() const noexcept {
    double low = 0;   // the gap is positive here,
    double high = 1;  // and not here
    double part = guess();
    if (!(part >= 0 && part <= 1)) part = terms_[0] / (terms_[0] - end_mv_);
    for (int i = 0; i < 60; ++i) {
        const double z = value(part);
        (z > 0 ? low : high) = part;
        const double rest = 1 + fall_ * part;
        const double x = x_ * rest;
        // Times `rest` it is dz/dε, and times its square the derivative after it.
        const double slope = (a_ + x) * z - x * reversal_mv_ + a_ * excess_mv_;
        const double bend = (a_ + x - 1) * slope + x * (z - reversal_mv_);
        const double square = slope * slope;
        const double step = z * rest * slope / (fall_ * std::max(0.5 * square, square - 0.5 * z * bend));
        double next = part - step;
        // The step is wrong where the square has left the range of a double.
        if (!(next >= low && next <= high) || std::isinf(square)) next = 0.5 * (low + high);
        // Convergence is cubic: after a step this small the error is below rounding.
        if (std::abs(next - part) <= 1e-6 * next) return fall_ * next;
        part = next;
    }
    return fall_ * part;
}

}  // namespace afferent
