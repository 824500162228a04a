#include "afferent/decoders/truncated_normal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace afferent {
namespace {

// Down to here nothing underflows, and the cancellation in the variance leaves ten digits.
constexpr double farthest = -30;

const double log_sqrt_two_pi = 0.5 * std::log(2 * std::numbers::pi);

double density(double x) { return std::exp(-0.5 * x * x - log_sqrt_two_pi); }

double below(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// Below −30 the density is taken for the exponential that it resembles near the upper limit. With rate r and
// length l, the distance from that limit has
//     mean 1/r − l/(e^(rl) − 1),   variance 1/r² − l² e^(rl)/(e^(rl) − 1)²
TruncatedNormal lower_tail(double low, double high) {
    const double rate = -high;
    const double length = high - low;
    const double x = std::min(rate * length, 500.0);
    const double grown = std::expm1(x);
    // The two terms cancel where x is small, and the distribution is uniform there.
    const double distance = x < 1e-3 ? length / 2 : 1 / rate - length / grown;
    const double variance =
        x < 1e-2 ? length * length / 12 : 1 / (rate * rate) - length * length * (grown + 1) / (grown * grown);
    const double log_mass =
        -0.5 * high * high - log_sqrt_two_pi - std::log(rate) + std::log(-std::expm1(-rate * length));
    return {high - distance, std::max(variance, 0.0), log_mass};
}

}  // namespace

TruncatedNormal truncated_normal(double low, double high) noexcept {
    if (low + high > 0) {
        const TruncatedNormal mirrored = truncated_normal(-high, -low);
        return {-mirrored.mean, mirrored.variance, mirrored.log_mass};
    }
    if (high < farthest) return lower_tail(low, high);
    const double length = high - low;
    if (length < 1e-3) {
        const double middle = (low + high) / 2;
        return {middle, length * length / 12, -0.5 * middle * middle - log_sqrt_two_pi + std::log(length)};
    }
    const double mass = below(high) - below(low);
    const double at_low = density(low);
    const double at_high = density(high);
    const double mean = (at_low - at_high) / mass;
    const double low_term = at_low > 0 ? low * at_low : 0;
    const double high_term = at_high > 0 ? high * at_high : 0;
    return {mean, std::max(1 + (low_term - high_term) / mass - mean * mean, 0.0), std::log(mass)};
}

}  // namespace afferent
