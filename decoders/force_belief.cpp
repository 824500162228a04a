#include "afferent/decoders/force_belief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "afferent/decoders/truncated_normal.hpp"

namespace afferent {
namespace {

using Gaussian = ForceBelief::Gaussian;
using Motion = ForceMotion;

// A motion never becomes so unlikely that it could not come back within some measurements.
constexpr double least_weight = 1e-6;
// A motion of less than this weight expects nothing.
constexpr double expected_weight = 1e-3;
constexpr double rest_variance_n2_per_s2 = 1;

// A bound is not sharp, and one that is so many standard deviations away changes nothing.
constexpr double softness_n2 = 1e-4;
constexpr double no_cut = 5;
// The logarithm of how probable it is that a bound is wrong.
constexpr double log_wrong_bound = -4.6;

void flow(Gaussian& x, const ForceFlow& by) {
    const Gaussian was = x;
    x.force_n = by.a * was.force_n + by.b * was.speed_n_per_s;
    x.speed_n_per_s = by.c * was.force_n + by.d * was.speed_n_per_s;
    x.ff = by.a * by.a * was.ff + 2 * by.a * by.b * was.fv + by.b * by.b * was.vv + by.ff;
    x.fv = by.a * by.c * was.ff + (by.a * by.d + by.b * by.c) * was.fv + by.b * by.d * was.vv + by.fv;
    x.vv = by.c * by.c * was.ff + 2 * by.c * by.d * was.fv + by.d * by.d * was.vv + by.vv;
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

// The moments of V, with another `variance` added to its variance.
struct SpeedProjection : Projection {
    SpeedProjection(const Gaussian& x, double variance_n2_per_s2) noexcept
        : Projection(x, 0, variance_n2_per_s2) {
        mean = x.speed_n_per_s;
        variance = x.vv + variance_n2_per_s2;
        gain_f = x.fv / variance;
        gain_v = x.vv / variance;
    }
};

// How the speed of a motion has changed within the lag.
double changed_n2_per_s2(const Motion& motion, double lag_s) {
    return motion.speed_n_per_s * motion.speed_n_per_s * 2 * lost_part(lag_s / motion.time_s);
}

// What the motion has strayed from a straight line within the lag.
double strayed_n2(const Motion& motion, double lag_s) {
    return motion.speed_n_per_s * motion.speed_n_per_s / motion.time_s * lag_s * lag_s * lag_s / 3;
}

}  // namespace

ForceBelief::ForceBelief(const Parameters& parameters, double largest_n) noexcept
    : parameters_(parameters), rest_(0.97) {
    for (std::size_t i = 0; i < motions; ++i) {
        const double speed_n_per_s = parameters.motion[i].speed_n_per_s;
        bank_[i] = {.force_n = 0,
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

void ForceBelief::weigh(const std::array<Likelihood, motions + 1>& likelihood) noexcept {
    double best = likelihood[motions].exponent;
    for (std::size_t i = 0; i < motions; ++i) best = std::max(best, likelihood[i].exponent);
    for (std::size_t i = 0; i < motions; ++i)
        bank_[i].weight *= likelihood[i].factor * std::exp(likelihood[i].exponent - best);
    rest_ *= likelihood[motions].factor * std::exp(likelihood[motions].exponent - best);
    normalise();
}

// First the mixture for each motion is replaced by a Gaussian with the same moments, then each flows.
void ForceBelief::predict(double dt_s) noexcept {
    if (!(dt_s > 0)) return;
    double share[motions + 1][motions];
    for (std::size_t i = 0; i < motions; ++i) {
        const Gaussian& x = bank_[i];
        const double releases =
            i == release ? 0 : lost_part(parameters_.releases_per_s(x.force_n, x.speed_n_per_s) * dt_s);
        const double leaves = lost_part(parameters_.motion[i].leaves_per_s * dt_s);
        for (std::size_t j = 0; j < motions; ++j)
            share[i][j] = x.weight * (1 - releases) * (i == j ? 1 - leaves : leaves * becomes[i][j]);
        share[i][release] += x.weight * releases;
    }
    const double from_rest = rest_ * lost_part(parameters_.leaves_rest_per_s * dt_s);
    for (std::size_t j = 0; j < motions; ++j) share[motions][j] = j == contact ? from_rest : 0;
    rest_ -= from_rest;

    const std::array<Gaussian, motions> before = bank_;
    const double contact_speed = parameters_.motion[contact].speed_n_per_s;
    const Gaussian left_rest = {0, 0, contact_variance_n2, 0, contact_speed * contact_speed, 0};
    const auto source = [&](std::size_t i) -> const Gaussian& { return i < motions ? before[i] : left_rest; };
    for (std::size_t j = 0; j < motions; ++j) {
        Gaussian mixed;
        for (std::size_t i = 0; i <= motions; ++i) mixed.weight += share[i][j];
        if (!(mixed.weight > 0)) continue;
        for (std::size_t i = 0; i <= motions; ++i) {
            mixed.force_n += share[i][j] / mixed.weight * source(i).force_n;
            mixed.speed_n_per_s += share[i][j] / mixed.weight * source(i).speed_n_per_s;
        }
        for (std::size_t i = 0; i <= motions; ++i) {
            const Gaussian& x = source(i);
            const double part = share[i][j] / mixed.weight;
            const double f = x.force_n - mixed.force_n;
            const double v = x.speed_n_per_s - mixed.speed_n_per_s;
            mixed.ff += part * (x.ff + f * f);
            mixed.fv += part * (x.fv + f * v);
            mixed.vv += part * (x.vv + v * v);
        }
        flow(mixed, parameters_.flow(j, dt_s));
        bank_[j] = mixed;
    }
    normalise();
}

void ForceBelief::measure(double force_n, double lag_s, double variance_n2) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Projection z(bank_[i], lag_s, variance_n2 + strayed_n2(parameters_.motion[i], lag_s));
        const double error_n = force_n - z.mean;
        likelihood[i] = {-0.5 * error_n * error_n / z.variance, 1 / std::sqrt(z.variance)};
        z.apply(bank_[i], error_n, 0);
    }
    const double at_rest_n2 = rest_variance_n2 + variance_n2;
    likelihood[motions] = {-0.5 * force_n * force_n / at_rest_n2, 1 / std::sqrt(at_rest_n2)};
    weigh(likelihood);
}

double ForceBelief::misfit(double force_n, double lag_s, double variance_n2) const noexcept {
    double least = rest_ < expected_weight ? std::numeric_limits<double>::infinity()
                                           : force_n * force_n / (rest_variance_n2 + variance_n2);
    for (std::size_t i = 0; i < motions; ++i) {
        if (bank_[i].weight < expected_weight) continue;
        const Projection z(bank_[i], lag_s, variance_n2 + strayed_n2(parameters_.motion[i], lag_s));
        least = std::min(least, (force_n - z.mean) * (force_n - z.mean) / z.variance);
    }
    return least;
}

// By moment matching. A bound may be wrong: one that next to nothing of a motion respects leaves it as it is.
void ForceBelief::bound(double bound_n, double lag_s) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Projection z(bank_[i], lag_s, softness_n2);
        const double sigma = std::sqrt(z.variance);
        const double highest = (std::max(bound_n, 1e-3) - z.mean) / sigma;
        if (highest > no_cut) continue;
        const TruncatedNormal cut = truncated_normal(-1e6, highest);
        likelihood[i].exponent = std::max(cut.log_mass, log_wrong_bound);
        if (cut.log_mass > log_wrong_bound) z.apply(bank_[i], sigma * cut.mean, cut.variance);
    }
    weigh(likelihood);
    for (std::size_t i = 0; i < motions; ++i) {
        Gaussian& x = bank_[i];
        const Projection z(x, 0, softness_n2);
        const double sigma = std::sqrt(z.variance);
        if (z.mean > no_cut * sigma) continue;
        const TruncatedNormal cut = truncated_normal(-z.mean / sigma, 1e6);
        z.apply(x, sigma * cut.mean, cut.variance);
        if (i == hold) continue;
        const double above = std::exp(cut.log_mass);
        rest_ += x.weight * (1 - above);
        x.weight *= above;
    }
    normalise();
}

// Its sign is that of the motion.
void ForceBelief::measure_speed(double speed_n_per_s, double lag_s, double variance_n2_per_s2) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const SpeedProjection z(bank_[i],
                                variance_n2_per_s2 + changed_n2_per_s2(parameters_.motion[i], lag_s));
        const double error = std::copysign(speed_n_per_s, z.mean) - z.mean;
        likelihood[i] = {-0.5 * error * error / z.variance, 1 / std::sqrt(z.variance)};
        z.apply(bank_[i], error, 0);
    }
    const double at_rest = rest_variance_n2_per_s2 + variance_n2_per_s2;
    likelihood[motions] = {-0.5 * speed_n_per_s * speed_n_per_s / at_rest, 1 / std::sqrt(at_rest)};
    weigh(likelihood);
}

void ForceBelief::bound_speed(double bound_n_per_s, double lag_s) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const SpeedProjection z(bank_[i], changed_n2_per_s2(parameters_.motion[i], lag_s));
        const double sigma = std::sqrt(z.variance);
        const TruncatedNormal cut =
            truncated_normal((-bound_n_per_s - z.mean) / sigma, (bound_n_per_s - z.mean) / sigma);
        z.apply(bank_[i], sigma * cut.mean, cut.variance);
        likelihood[i].exponent = cut.log_mass;
    }
    weigh(likelihood);
}

ForceBelief::Moments ForceBelief::of_speed() const noexcept {
    double mean = 0;
    double square = 0;
    for (const Gaussian& x : bank_) {
        mean += x.weight * std::abs(x.speed_n_per_s);
        square += x.weight * (x.vv + x.speed_n_per_s * x.speed_n_per_s);
    }
    return {mean, std::max(square - mean * mean, 0.0)};
}

ForceBelief::Moments ForceBelief::of_past(double lag_s) const noexcept {
    double mean_n = 0;
    double square_n2 = 0;
    for (const Gaussian& x : bank_) {
        const Projection z(x, lag_s, 0);
        mean_n += x.weight * z.mean;
        square_n2 += x.weight * (z.variance + z.mean * z.mean);
    }
    return {mean_n, std::max(square_n2 - mean_n * mean_n, 0.0)};
}

}  // namespace afferent
