#include "afferent/decoders/force_belief.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/decoders/truncated_normal.hpp"

namespace afferent {
namespace {

using Gaussian = ForceBelief::Gaussian;
using Motion = ForceBelief::Motion;

// A motion never becomes so unlikely that it could not come back within some measurements.
constexpr double least_weight = 1e-6;
// Below zero the force is at rest within this time.
constexpr double rest_time_s = 0.02;
constexpr double rest_variance_n2 = 0.0025;
// A force that has just left rest.
constexpr double contact_variance_n2 = 0.05;
constexpr double contact = 2;

// Where a motion goes when it is left: half of what leaves a hold becomes a movement, and so on.
constexpr double becomes[3][3] = {{0, 0.5, 0.5}, {0.8, 0, 0.2}, {0.1, 0.9, 0}};

// The part of `rate` that happens within dt.
double within(double rate_per_s, double dt_s) { return -std::expm1(-rate_per_s * dt_s); }

// The exact moments of the Ornstein–Uhlenbeck process and its integral.
void flow(Gaussian& x, const Motion& motion, double dt_s) {
    const double r = dt_s / motion.time_s;
    const double lost = -std::expm1(-r);
    const double kept = 1 - lost;
    const double reach_s = motion.time_s * lost;
    const double vv = motion.speed_n_per_s * motion.speed_n_per_s;
    // r → 0: 2 r³/3, where the terms cancel.
    const double spread = r < 1e-2 ? 2 * r * r * r / 3 : 2 * r - 4 * lost + lost * (1 + kept);
    const double ff = x.ff + 2 * reach_s * x.fv + reach_s * reach_s * x.vv +
                      vv * motion.time_s * motion.time_s * spread + motion.drift_n2_per_s * dt_s;
    const double fv = kept * (x.fv + reach_s * x.vv) + vv * motion.time_s * lost * lost;
    x.force_n += reach_s * x.speed_n_per_s;
    x.speed_n_per_s *= kept;
    x.vv = kept * kept * x.vv + vv * lost * (1 + kept);
    x.ff = ff;
    x.fv = fv;
}

// The moments of z = F − lag V, with another `variance` added to its variance.
struct Projection {
    double mean, variance, gain_f, gain_v;
    Projection(const Gaussian& x, double lag_s, double variance_n2) noexcept {
        const double f = x.ff - lag_s * x.fv;
        const double v = x.fv - lag_s * x.vv;
        mean = x.force_n - lag_s * x.speed_n_per_s;
        variance = f - lag_s * v + variance_n2;
        gain_f = f / variance;
        gain_v = v / variance;
    }
    // z has moved by `shift`, and its variance has become `part` of what it was.
    void apply(Gaussian& x, double shift, double part) const noexcept {
        const double taken = (1 - part) * variance;
        x.force_n += gain_f * shift;
        x.speed_n_per_s += gain_v * shift;
        x.ff -= gain_f * gain_f * taken;
        x.fv -= gain_f * gain_v * taken;
        x.vv -= gain_v * gain_v * taken;
    }
};

double log_density(double error, double variance) {
    return -0.5 * (error * error / variance + std::log(variance));
}

}  // namespace

ForceBelief::ForceBelief(const Parameters& parameters, double largest_n) noexcept
    : parameters_(parameters), rest_(0.97) {
    for (int i = 0; i < motions; ++i) {
        const double speed_n_per_s = parameters.motion[static_cast<std::size_t>(i)].speed_n_per_s;
        bank_[static_cast<std::size_t>(i)] = {.force_n = 0,
                                              .speed_n_per_s = 0,
                                              .ff = largest_n * largest_n / 4,
                                              .fv = 0,
                                              .vv = speed_n_per_s * speed_n_per_s,
                                              .weight = 0.01};
    }
}

void ForceBelief::normalise() noexcept {
    double sum = rest_;
    for (const Gaussian& x : bank_) sum += x.weight;
    double raised = 0;
    for (Gaussian& x : bank_) raised += x.weight = std::max(x.weight / sum, least_weight);
    rest_ = std::max(rest_ / sum, least_weight);
    const double scale = 1 / (rest_ + raised);
    for (Gaussian& x : bank_) x.weight *= scale;
    rest_ *= scale;
}

void ForceBelief::weigh(const std::array<double, motions + 1>& log_likelihood) noexcept {
    const double best = *std::max_element(log_likelihood.begin(), log_likelihood.end());
    for (std::size_t i = 0; i < motions; ++i) bank_[i].weight *= std::exp(log_likelihood[i] - best);
    rest_ *= std::exp(log_likelihood[motions] - best);
    normalise();
}

// First the mixture for each motion is replaced by a Gaussian with the same moments, then each flows.
void ForceBelief::predict(double dt_s) noexcept {
    if (!(dt_s > 0)) return;
    double share[motions + 1][motions];
    double to_rest = 0;
    for (int i = 0; i < motions; ++i) {
        const Gaussian& x = bank_[static_cast<std::size_t>(i)];
        const Motion& motion = parameters_.motion[static_cast<std::size_t>(i)];
        const double below = 0.5 * std::erfc(x.force_n / std::sqrt(2 * x.ff));
        const double falling_per_s = std::max(0.0, -x.speed_n_per_s) / std::max(x.force_n, 0.3);
        const double stays = (1 - below * within(1 / rest_time_s, dt_s)) *
                             std::exp(-parameters_.comes_to_rest * falling_per_s * dt_s);
        const double leaves = within(motion.leaves_per_s, dt_s);
        to_rest += x.weight * (1 - stays);
        for (int j = 0; j < motions; ++j)
            share[i][j] = x.weight * stays * (i == j ? 1 - leaves : leaves * becomes[i][j]);
    }
    const double from_rest = rest_ * within(parameters_.leaves_rest_per_s, dt_s);
    for (int j = 0; j < motions; ++j) share[motions][j] = j == contact ? from_rest : 0;
    rest_ += to_rest - from_rest;

    const std::array<Gaussian, motions> before = bank_;
    const double contact_speed = parameters_.motion[motions - 1].speed_n_per_s;
    const Gaussian left_rest = {0, 0, contact_variance_n2, 0, contact_speed * contact_speed, 0};
    const auto source = [&](int i) -> const Gaussian& {
        return i < motions ? before[static_cast<std::size_t>(i)] : left_rest;
    };
    for (int j = 0; j < motions; ++j) {
        Gaussian mixed;
        for (int i = 0; i <= motions; ++i) mixed.weight += share[i][j];
        for (int i = 0; i <= motions; ++i) {
            mixed.force_n += share[i][j] / mixed.weight * source(i).force_n;
            mixed.speed_n_per_s += share[i][j] / mixed.weight * source(i).speed_n_per_s;
        }
        for (int i = 0; i <= motions; ++i) {
            const Gaussian& x = source(i);
            const double part = share[i][j] / mixed.weight;
            const double f = x.force_n - mixed.force_n;
            const double v = x.speed_n_per_s - mixed.speed_n_per_s;
            mixed.ff += part * (x.ff + f * f);
            mixed.fv += part * (x.fv + f * v);
            mixed.vv += part * (x.vv + v * v);
        }
        flow(mixed, parameters_.motion[static_cast<std::size_t>(j)], dt_s);
        bank_[static_cast<std::size_t>(j)] = mixed;
    }
    normalise();
}

void ForceBelief::measure(double force_n, double lag_s, double variance_n2) noexcept {
    std::array<double, motions + 1> log_likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Motion& motion = parameters_.motion[i];
        // What the motion has strayed from a straight line within the lag.
        const double strayed_n2 =
            motion.speed_n_per_s * motion.speed_n_per_s / motion.time_s * lag_s * lag_s * lag_s / 3;
        const Projection z(bank_[i], lag_s, variance_n2 + strayed_n2);
        log_likelihood[i] = log_density(force_n - z.mean, z.variance);
        z.apply(bank_[i], force_n - z.mean, 0);
    }
    log_likelihood[motions] = log_density(force_n, rest_variance_n2 + variance_n2);
    weigh(log_likelihood);
}

// Moment matching.
void ForceBelief::bound(double bound_n, double lag_s) noexcept {
    constexpr double softness_n2 = 1e-4;
    std::array<double, motions + 1> log_likelihood{};
    for (std::size_t i = 0; i < motions; ++i)
        for (const bool past : {true, false}) {
            const Projection z(bank_[i], past ? lag_s : 0, softness_n2);
            const double sigma = std::sqrt(z.variance);
            const double highest_n = past ? std::max(bound_n, 1e-3) : std::max(1e6, 2 * bound_n);
            const TruncatedNormal cut = truncated_normal(-z.mean / sigma, (highest_n - z.mean) / sigma);
            z.apply(bank_[i], sigma * cut.mean, cut.variance);
            log_likelihood[i] += cut.log_mass;
        }
    weigh(log_likelihood);
}

double ForceBelief::mean_n() const noexcept {
    double mean_n = 0;
    for (const Gaussian& x : bank_) mean_n += x.weight * x.force_n;
    return mean_n;
}

double ForceBelief::variance_n2() const noexcept {
    const double mean_n = this->mean_n();
    double variance_n2 = rest_ * mean_n * mean_n;
    for (const Gaussian& x : bank_)
        variance_n2 += x.weight * (x.ff + (x.force_n - mean_n) * (x.force_n - mean_n));
    return variance_n2;
}

}  // namespace afferent
