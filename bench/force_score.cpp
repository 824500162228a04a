#include "bench/force_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace afferent {
namespace {

// The correlation of the estimate with the force `lag` steps before.
double correlation(const FollowedForce& force, std::size_t from, std::size_t lag) {
    double x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    const auto n = static_cast<double>(force.estimates.size() - from);
    for (std::size_t k = from; k < force.estimates.size(); ++k) {
        const double truth = force.true_n[k - lag];
        const double estimate = force.estimates[k].force_n;
        x += truth;
        y += estimate;
        xx += truth * truth;
        yy += estimate * estimate;
        xy += truth * estimate;
    }
    return (xy - x * y / n) / std::sqrt((xx - x * x / n) * (yy - y * y / n));
}

// Between steps by the parabola through the best and its neighbours.
double best_lag(const FollowedForce& force, std::size_t most) {
    if (force.estimates.size() < 3 * most) return 0;
    std::vector<double> found;
    for (std::size_t lag = 0; lag <= most; ++lag) found.push_back(correlation(force, most, lag));
    const auto best = static_cast<std::size_t>(std::max_element(found.begin(), found.end()) - found.begin());
    if (best == 0 || best == most) return static_cast<double>(best);
    const double curvature = found[best - 1] - 2 * found[best] + found[best + 1];
    const double shift = curvature < 0 ? (found[best - 1] - found[best + 1]) / (2 * curvature) : 0;
    return static_cast<double>(best) + shift;
}

}  // namespace

ForceScore score(std::span<const FollowedForce> forces, Duration step) {
    ForceScore score{.overshoot_n = -std::numeric_limits<double>::infinity()};
    const auto steps_in = [step](Duration time) { return static_cast<std::size_t>(time / step); };
    const std::size_t hold = steps_in(400ms);
    std::vector<double> errors_n;
    double squares = 0, sensed_squares = 0, bias_n = 0;
    std::size_t inside = 0, held = 0;
    for (const FollowedForce& force : forces) {
        const double largest_n = *std::max_element(force.true_n.begin(), force.true_n.end());
        std::size_t contact_until = 0;
        for (std::size_t k = 0; k < force.estimates.size(); ++k) {
            const double true_n = force.true_n[k];
            const double force_n = force.estimates[k].force_n;
            const double sigma_n = force.estimates[k].sigma_n;
            const double error_n = force_n - true_n;
            const double decoding_error_n = force_n - force.decodable_n[k];
            errors_n.push_back(std::abs(error_n));
            squares += error_n * error_n;
            sensed_squares += std::pow(force_n - force.sensed_n[k], 2);
            inside += std::abs(decoding_error_n) <= 1.96 * sigma_n;
            if (k >= hold && true_n > 0.1 * largest_n &&
                std::abs(true_n - force.true_n[k - hold]) < 0.02 * true_n) {
                bias_n += decoding_error_n;
                ++held;
            }
            const bool above = true_n > 0.05 * largest_n;
            if (above && (k == 0 || force.true_n[k - 1] <= 0.05 * largest_n))
                contact_until = k + steps_in(500ms);
            if (k < contact_until) score.overshoot_n = std::max(score.overshoot_n, error_n);
        }
        score.delay_ms += best_lag(force, steps_in(200ms)) * Milliseconds(step).count() /
                          static_cast<double>(forces.size());
    }
    const auto n = static_cast<double>(errors_n.size());
    score.rms_n = std::sqrt(squares / n);
    score.rms_sensed_n = std::sqrt(sensed_squares / n);
    const auto p95 = errors_n.begin() + static_cast<std::ptrdiff_t>(0.95 * n);
    std::nth_element(errors_n.begin(), p95, errors_n.end());
    score.p95_n = *p95;
    score.hold_bias_n = held > 0 ? bias_n / static_cast<double>(held) : 0;
    score.coverage_95 = static_cast<double>(inside) / n;
    return score;
}

}  // namespace afferent
