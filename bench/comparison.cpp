#include "bench/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace afferent::bench {

void Comparison::add(const Train& truth, const Train& train) {
    constexpr double ns = 1e-9;
    const auto apart_s = [](const SpikeTime& a, const SpikeTime& b) { return (a - b).count() * ns; };
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < truth.size() && j < train.size()) {
        double window_s = std::numeric_limits<double>::infinity();
        if (i > 0) window_s = std::min(window_s, 0.5 * apart_s(truth[i], truth[i - 1]));
        if (i + 1 < truth.size()) window_s = std::min(window_s, 0.5 * apart_s(truth[i + 1], truth[i]));
        const double late_s = apart_s(train[j], truth[i]);
        if (std::abs(late_s) <= std::max(window_s, ns)) {
            errors_s.push_back(std::abs(late_s));
            const double allowed_s = std::max(ns, 1e-12 * apart_s(truth[i], {scene_start, Interval(0)}));
            if (std::abs(late_s) > allowed_s) worst_beyond_s = std::max(worst_beyond_s, std::abs(late_s));
            ++i;
            ++j;
        } else if (late_s < 0) {
            ++extra;
            ++j;
        } else {
            ++missed;
            ++i;
        }
    }
    missed += truth.size() - i;
    extra += train.size() - j;
}

double Comparison::quantile_s(double share) const {
    if (errors_s.empty()) return 0;
    std::vector<double> sorted = errors_s;
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), sorted.begin() + at, sorted.end());
    return sorted[static_cast<std::size_t>(at)];
}

double Comparison::rms_s() const {
    double sum = 0;
    for (const double error : errors_s) sum += error * error;
    return errors_s.empty() ? 0 : std::sqrt(sum / static_cast<double>(errors_s.size()));
}

double Comparison::max_s() const {
    return errors_s.empty() ? 0 : *std::max_element(errors_s.begin(), errors_s.end());
}

}  // namespace afferent::bench
