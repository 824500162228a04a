#include "afferent/decoders/motion_fit.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <numbers>

namespace afferent {
namespace {

constexpr double farthest_fit = 30;  // from where the fit began
constexpr int rounds = 4;
constexpr int bits = 12;  // of the logarithm of a strength: far below what data can tell
constexpr std::size_t groups = 24;

// Calls f(sigma_n, error_n) for each point but the first.
template <class F>
void foretell(const ForceTrace& force, double noise_n, const ForceBelief::Parameters& parameters,
              const F& f) {
    const double largest_n = 1 + std::ranges::max_element(force, {}, &ForcePoint::force_n)->force_n;
    ForceBelief belief(parameters, largest_n);
    const double noise_n2 = noise_n * noise_n;
    double before_s = force.front().time_s;
    for (const auto& [time_s, force_n] : force) {
        if (time_s > before_s) {
            belief.predict(time_s - before_s);
            f(std::sqrt(belief.variance_n2() + noise_n2), force_n - belief.mean_n());
        }
        belief.measure(force_n, {}, noise_n2);
        before_s = time_s;
    }
}

}  // namespace

MotionFit fit_motions(const ForceTrace& force, double noise_n, const ForceBelief::Parameters& from) {
    const auto score = [&](const ForceBelief::Parameters& parameters) {
        double sum = 0;
        foretell(force, noise_n, parameters, [&](double sigma_n, double error_n) {
            const double z = error_n / sigma_n;
            sum -= z * z / 2 + std::log(sigma_n * std::sqrt(2 * std::numbers::pi));
        });
        return sum / static_cast<double>(force.size() - 1);
    };
    MotionFit fit{.force = from, .score_before = score(from), .score = 0, .foretold = {}};
    fit.score = fit.score_before;
    // The strengths to be fitted, each with the value that it began with.
    auto& motion = fit.force.motion;
    const std::pair<double*, double> strengths[]{{&motion[1].speed_n_per_s, from.motion[1].speed_n_per_s},
                                                 {&motion[2].speed_n_per_s, from.motion[2].speed_n_per_s},
                                                 {&motion[0].speed_n_per_s, from.motion[0].speed_n_per_s},
                                                 {&motion[0].drift_n2_per_s, from.motion[0].drift_n2_per_s}};
    for (int round = 0; round < rounds; ++round) {
        const double before = fit.score;
        for (const auto& [strength, was] : strengths) {
            const double best = *strength;
            const auto [log_factor, loss] = boost::math::tools::brent_find_minima(
                [&, strength = strength, was = was](double x) {
                    *strength = was * std::exp(x);
                    return -score(fit.force);
                },
                -std::log(farthest_fit), std::log(farthest_fit), bits);
            // The search may end in a minimum that is worse than where it began.
            *strength = -loss > fit.score ? was * std::exp(log_factor) : best;
            fit.score = std::max(fit.score, -loss);
        }
        if (fit.score - before < 1e-3) break;
    }
    std::vector<MotionFit::Foretold> all;
    foretell(force, noise_n, fit.force, [&](double sigma_n, double error_n) {
        all.push_back({sigma_n, error_n * error_n});
    });
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.sigma_n < b.sigma_n; });
    for (std::size_t group = 0; group < groups; ++group) {
        const std::size_t begin = group * all.size() / groups;
        const std::size_t end = (group + 1) * all.size() / groups;
        if (begin == end) continue;
        MotionFit::Foretold mean{0, 0};
        for (std::size_t i = begin; i < end; ++i) {
            mean.sigma_n += all[i].sigma_n * all[i].sigma_n;
            mean.error_n += all[i].error_n;
        }
        const auto count = static_cast<double>(end - begin);
        fit.foretold.push_back({std::sqrt(mean.sigma_n / count), std::sqrt(mean.error_n / count)});
    }
    return fit;
}

}  // namespace afferent
