#include "afferent/decoders/force_belief.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "afferent/decoders/truncated_normal.hpp"

namespace afferent {
namespace {

using Gaussian = ForceBelief::Gaussian;
using Motion = ForceBelief::Motion;

// A motion never becomes so unlikely that it could not come back within some measurements.
constexpr double least_weight = 1e-6;
// A motion of less than this weight expects nothing.
constexpr double expected_weight = 1e-3;
// Below this the force is at rest within this time.
constexpr double at_rest_n = 0.02;
constexpr double rest_time_s = 0.02;
constexpr double rest_variance_n2 = 0.0025;
constexpr double rest_variance_n2_per_s2 = 1;
// A force that has just left rest.
constexpr double contact_variance_n2 = 0.05;

// The logarithm of how probable it is that a bound is wrong.
constexpr double log_wrong_bound = -4.6;

// Where a motion goes when it is left: half of what leaves a hold becomes a movement, and so on.
constexpr double becomes[4][4] = {{0, 0.5, 0.5, 0}, {0.8, 0, 0.2, 0}, {0.1, 0.9, 0, 0}, {0.3, 0.5, 0.2, 0}};

// 1 − e^(−r), and 2r − 3 + 4e^(−r) − e^(−2r), whose terms cancel where r is small. Steps are short against
// the time constants, and their series are faster than the functions.
constexpr double short_step = 0.2;
double lost_part(double r) {
    if (r > short_step) return -std::expm1(-r);
    return r * (1 - r / 2 * (1 - r / 3 * (1 - r / 4 * (1 - r / 5 * (1 - r / 6 * (1 - r / 7))))));
}
double spread(double r, double lost) {
    if (r > short_step) return 2 * r - 4 * lost + lost * (2 - lost);
    return r * r * r *
           (2.0 / 3 - r * (1.0 / 2 - r * (7.0 / 30 - r * (1.0 / 12 - r * (31.0 / 1260 - r / 160)))));
}

// The exact moments of the Ornstein–Uhlenbeck process and its integral.
void flow(Gaussian& x, const Motion& motion, double dt_s) {
    const double r = dt_s / motion.time_s;
    const double lost = lost_part(r);
    const double kept = 1 - lost;
    const double reach_s = motion.time_s * lost;
    const double vv = motion.speed_n_per_s * motion.speed_n_per_s;
    const double ff = x.ff + 2 * reach_s * x.fv + reach_s * reach_s * x.vv +
                      vv * motion.time_s * motion.time_s * spread(r, lost) + motion.drift_n2_per_s * dt_s;
    const double fv = kept * (x.fv + reach_s * x.vv) + vv * motion.time_s * lost * lost;
    x.force_n += reach_s * x.speed_n_per_s;
    x.speed_n_per_s *= kept;
    x.vv = kept * kept * x.vv + vv * lost * (1 + kept);
    x.ff = ff;
    x.fv = fv;
}

// The exact mean of the critically damped oscillator; its noise is that of a step that is short against τ.
void flow_back(Gaussian& x, const Motion& motion, double dt_s) {
    const double r = dt_s / motion.time_s;
    const double fall = 1 - lost_part(r);
    const double a = fall * (1 + r);
    const double b = fall * dt_s;
    const double c = -fall * r / motion.time_s;
    const double d = fall * (1 - r);
    const double noisy_s = std::min(dt_s, motion.time_s / 2);
    const double noise = 2 * motion.speed_n_per_s * motion.speed_n_per_s * noisy_s / motion.time_s;
    const Gaussian before = x;
    x.force_n = a * before.force_n + b * before.speed_n_per_s;
    x.speed_n_per_s = c * before.force_n + d * before.speed_n_per_s;
    x.ff = a * a * before.ff + 2 * a * b * before.fv + b * b * before.vv + noise * noisy_s * noisy_s / 3 +
           motion.drift_n2_per_s * dt_s;
    x.fv = a * c * before.ff + (a * d + b * c) * before.fv + b * d * before.vv + noise * noisy_s / 2;
    x.vv = c * c * before.ff + 2 * c * d * before.fv + d * d * before.vv + noise;
}

// Of a force that has fallen below 0 by so many standard deviations: the part of the Gaussian that is there.
double part_below(double deviations) {
    return deviations > 6 ? 0 : 0.5 * std::erfc(deviations / std::numbers::sqrt2);
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
    double to_rest = 0;
    for (int i = 0; i < motions; ++i) {
        const Gaussian& x = bank_[static_cast<std::size_t>(i)];
        const Motion& motion = parameters_.motion[static_cast<std::size_t>(i)];
        const double below =
            part_below((x.force_n - at_rest_n) / std::sqrt(x.ff)) * lost_part(dt_s / rest_time_s);
        const double falling_per_s = std::max(0.0, -x.speed_n_per_s) / std::max(x.force_n, 0.3);
        const double releases = i == release ? 0 : lost_part(parameters_.releases * falling_per_s * dt_s);
        const double leaves = lost_part(motion.leaves_per_s * dt_s);
        to_rest += x.weight * below;
        const double moves = x.weight * (1 - below);
        for (int j = 0; j < motions; ++j)
            share[i][j] = moves * (1 - releases) * (i == j ? 1 - leaves : leaves * becomes[i][j]);
        share[i][release] += moves * releases;
    }
    const double from_rest = rest_ * lost_part(parameters_.leaves_rest_per_s * dt_s);
    for (int j = 0; j < motions; ++j) share[motions][j] = j == contact ? from_rest : 0;
    rest_ += to_rest - from_rest;

    const std::array<Gaussian, motions> before = bank_;
    const double contact_speed = parameters_.motion[contact].speed_n_per_s;
    const Gaussian left_rest = {0, 0, contact_variance_n2, 0, contact_speed * contact_speed, 0};
    const auto source = [&](int i) -> const Gaussian& {
        return i < motions ? before[static_cast<std::size_t>(i)] : left_rest;
    };
    for (int j = 0; j < motions; ++j) {
        Gaussian mixed;
        for (int i = 0; i <= motions; ++i) mixed.weight += share[i][j];
        if (!(mixed.weight > 0)) continue;
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
        (j == release ? flow_back : flow)(mixed, parameters_.motion[static_cast<std::size_t>(j)], dt_s);
        bank_[static_cast<std::size_t>(j)] = mixed;
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

// Moment matching. A bound may be wrong: one that next to nothing of a motion respects leaves it as it is.
void ForceBelief::bound(double bound_n, double lag_s) noexcept {
    constexpr double softness_n2 = 1e-4;
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i)
        for (const bool past : {true, false}) {
            const Projection z(bank_[i], past ? lag_s : 0, softness_n2);
            const double sigma = std::sqrt(z.variance);
            const double highest_n = past ? std::max(bound_n, 1e-3) : std::max(1e6, 2 * bound_n);
            const TruncatedNormal cut = truncated_normal(-z.mean / sigma, (highest_n - z.mean) / sigma);
            likelihood[i].exponent += std::max(cut.log_mass, log_wrong_bound);
            if (!past || cut.log_mass > log_wrong_bound) z.apply(bank_[i], sigma * cut.mean, cut.variance);
        }
    weigh(likelihood);
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
