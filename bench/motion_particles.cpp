#include "bench/motion_particles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace afferent {
namespace {

// Nothing is released at first.
constexpr std::array first_motion{ForceBelief::hold + 0, ForceBelief::movement + 0, ForceBelief::contact + 0,
                                  MotionParticles::rest};
constexpr std::array first_weight{0.01, 0.01, 0.01, 0.97};

// So much of the proposals goes to all motions alike, and its weight is corrected: a motion that is rare but
// possible is always tried.
constexpr double tried = 0.2;

double within(double rate_per_s, double dt_s) { return -std::expm1(-rate_per_s * dt_s); }

}  // namespace

MotionParticles::MotionParticles(double largest_n, const Options& options)
    : parameters_(options.model),
      variables_(2 + options.variables),
      particles_(options.particles),
      states_(options.particles * variables_ * (variables_ + 1)),
      column_(variables_),
      random_(options.seed) {
    point();
    for (std::size_t i = 0; i < particles_.size(); ++i) {
        Particle& x = particles_[i];
        start(x, first_motion[i % first_motion.size()]);
        x.weight = first_weight[i % first_weight.size()];
        x.log_weight = std::log(x.weight);
        if (x.motion != rest) covariance(x, force, force) = largest_n * largest_n / 4;
    }
}

void MotionParticles::point() {
    double* state = states_.data();
    for (Particle& x : particles_) {
        x.mean = state;
        x.covariance = state + variables_;
        state += variables_ * (variables_ + 1);
    }
}

// Force and speed are those of the motion's begin, and nothing that was known of them before counts.
void MotionParticles::start(Particle& x, int motion) const {
    x.motion = motion;
    for (const std::size_t i : {force, speed}) {
        x.mean[i] = 0;
        for (std::size_t j = 0; j < variables_; ++j) covariance(x, i, j) = covariance(x, j, i) = 0;
    }
    if (motion == rest) {
        covariance(x, force, force) = ForceBelief::rest_variance_n2;
        return;
    }
    const double speed_n_per_s = parameters_.motion[static_cast<std::size_t>(motion)].speed_n_per_s;
    covariance(x, force, force) = ForceBelief::contact_variance_n2;
    covariance(x, speed, speed) = speed_n_per_s * speed_n_per_s;
}

void MotionParticles::change_motion(Particle& x, double dt_s) {
    std::array<double, rest + 1> chance{};
    if (x.motion == rest) {
        chance[ForceBelief::contact] = within(parameters_.leaves_rest_per_s, dt_s);
        chance[rest] = 1 - chance[ForceBelief::contact];
    } else {
        const auto motion = static_cast<std::size_t>(x.motion);
        const double releases_per_s =
            x.motion == ForceBelief::release ? 0 : parameters_.releases_per_s(x.mean[force], x.mean[speed]);
        const double releases = within(releases_per_s, dt_s);
        const double leaves = within(parameters_.motion[motion].leaves_per_s, dt_s);
        for (std::size_t j = 0; j < rest; ++j)
            chance[j] =
                (1 - releases) * (j == motion ? 1 - leaves : leaves * ForceBelief::becomes[motion][j]);
        chance[ForceBelief::release] += releases;
    }
    const auto possible = std::count_if(chance.begin(), chance.end(), [](double p) { return p > 0; });
    double left = std::uniform_real_distribution<double>()(random_);
    for (std::size_t j = 0; j < chance.size(); ++j) {
        if (!(chance[j] > 0)) continue;
        const double proposed = (1 - tried) * chance[j] + tried / static_cast<double>(possible);
        left -= proposed;
        if (left > 0 && std::any_of(chance.begin() + static_cast<std::ptrdiff_t>(j) + 1, chance.end(),
                                    [](double p) { return p > 0; }))
            continue;
        x.log_weight += std::log(chance[j] / proposed);
        const int motion = static_cast<int>(j);
        if (motion == rest || x.motion == rest) start(x, motion);
        x.motion = motion;
        return;
    }
}

void MotionParticles::flow(Particle& x, double dt_s) const {
    if (x.motion == rest) return;
    const ForceFlow by = afferent::flow(parameters_, static_cast<std::size_t>(x.motion), dt_s);
    const auto step = [&by](double& f, double& v) {
        const double before = f;
        f = by.a * before + by.b * v;
        v = by.c * before + by.d * v;
    };
    step(x.mean[force], x.mean[speed]);
    for (std::size_t j = 0; j < variables_; ++j) step(covariance(x, force, j), covariance(x, speed, j));
    for (std::size_t i = 0; i < variables_; ++i) step(covariance(x, i, force), covariance(x, i, speed));
    covariance(x, force, force) += by.ff;
    covariance(x, force, speed) += by.fv;
    covariance(x, speed, force) += by.fv;
    covariance(x, speed, speed) += by.vv;
}

void MotionParticles::predict(double dt_s) {
    for (Particle& x : particles_) {
        change_motion(x, dt_s);
        flow(x, dt_s);
        meet_zero(x);
    }
}

void MotionParticles::drive(std::size_t variable, double a, double b, double c, double variance) {
    for (Particle& x : particles_) {
        x.mean[variable] = a * x.mean[variable] + b * x.mean[force] + c;
        double* const row = &x.covariance[variable * variables_];
        const double* const f = &x.covariance[force * variables_];
        for (std::size_t j = 0; j < variables_; ++j) row[j] = a * row[j] + b * f[j];
        for (std::size_t i = 0; i < variables_; ++i)
            covariance(x, i, variable) = a * covariance(x, i, variable) + b * covariance(x, i, force);
        row[variable] += variance;
    }
}

void MotionParticles::measure(Particle& x, std::size_t variable, double value, double variance) {
    const double total = covariance(x, variable, variable) + variance;
    const double error = value - x.mean[variable];
    x.log_weight -= 0.5 * (error * error / total + std::log(2 * std::numbers::pi * total));
    for (std::size_t i = 0; i < variables_; ++i) column_[i] = covariance(x, i, variable);
    for (std::size_t i = 0; i < variables_; ++i) {
        x.mean[i] += column_[i] / total * error;
        for (std::size_t j = 0; j < variables_; ++j) covariance(x, i, j) -= column_[i] * column_[j] / total;
    }
}

void MotionParticles::measure(std::size_t variable, double value, double variance) {
    for (Particle& x : particles_) measure(x, variable, value, variance);
}

void MotionParticles::cut(Particle& x, std::size_t variable, const TruncatedNormal& to, double sigma) {
    for (std::size_t i = 0; i < variables_; ++i) column_[i] = covariance(x, i, variable) / sigma;
    for (std::size_t i = 0; i < variables_; ++i) {
        x.mean[i] += column_[i] * to.mean;
        for (std::size_t j = 0; j < variables_; ++j)
            covariance(x, i, j) -= column_[i] * column_[j] * (1 - to.variance);
    }
}

void MotionParticles::truncate(std::size_t variable, double low, double high) {
    for (Particle& x : particles_) {
        const double sigma = std::sqrt(std::max(covariance(x, variable, variable), 1e-12));
        const double from = (low - x.mean[variable]) / sigma;
        const double to = (high - x.mean[variable]) / sigma;
        if (from < -4 && to > 4) continue;
        const TruncatedNormal within = truncated_normal(from, to);
        x.log_weight += within.log_mass;
        cut(x, variable, within, sigma);
    }
}

// What has become negative is at rest, and what has not is cut off at 0; so is a hold.
void MotionParticles::meet_zero(Particle& x) {
    if (x.motion == rest) return;
    const double sigma = std::sqrt(covariance(x, force, force));
    const double below = 0.5 * std::erfc(x.mean[force] / sigma / std::numbers::sqrt2);
    if (below < 1e-6) return;
    if (x.motion == ForceBelief::hold)
        return cut(x, force, truncated_normal(-x.mean[force] / sigma, 1e6), sigma);
    const double proposed = (1 - tried) * below + tried / 2;
    if (std::uniform_real_distribution<double>()(random_) < proposed) {
        x.log_weight += std::log(below / proposed);
        start(x, rest);
    } else {
        x.log_weight += std::log((1 - below) / (1 - proposed));
        cut(x, force, truncated_normal(-x.mean[force] / sigma, 1e6), sigma);
    }
}

void MotionParticles::set(std::size_t variable, double value) {
    for (Particle& x : particles_) {
        x.mean[variable] = value;
        for (std::size_t j = 0; j < variables_; ++j)
            covariance(x, variable, j) = covariance(x, j, variable) = 0;
    }
}

void MotionParticles::cross_zero(std::size_t variable, double a, double b, double span) {
    // The mean of the positive part of the speed.
    const auto flux_of = [&](Particle& x) {
        const double mean = a + b * x.mean[force];
        const double sigma = std::abs(b) * std::sqrt(std::max(covariance(x, force, force), 1e-12));
        const double u = mean / sigma;
        const double density = std::exp(-0.5 * u * u) / std::sqrt(2 * std::numbers::pi);
        const double flux = mean * 0.5 * std::erfc(-u / std::numbers::sqrt2) + sigma * density;
        return std::max(flux, 1e-9 * sigma);
    };
    for (Particle& x : particles_) {
        const double reached = flux_of(x) * span;
        measure(x, variable, 0, reached * reached / 12);
        x.log_weight += std::log(flux_of(x));
    }
}

// Systematic resampling.
void MotionParticles::resample() {
    double best = -std::numeric_limits<double>::infinity();
    for (Particle& x : particles_) {
        // Nearly equal variables may lose a covariance to rounding.
        if (!std::isfinite(x.log_weight)) x.log_weight = -1e300;
        best = std::max(best, x.log_weight);
    }
    double sum = 0;
    double squares = 0;
    for (Particle& x : particles_) {
        x.log_weight -= best;
        x.weight = std::exp(x.log_weight);
        sum += x.weight;
        squares += x.weight * x.weight;
    }
    const auto count = static_cast<double>(particles_.size());
    if (sum * sum / squares > count / 2) return;
    const std::size_t size = variables_ * (variables_ + 1);
    std::vector<double> drawn_states;
    drawn_states.reserve(states_.size());
    std::vector<Particle> drawn;
    drawn.reserve(particles_.size());
    double next = std::uniform_real_distribution<double>()(random_);
    double reached = 0;
    for (const Particle& x : particles_) {
        reached += x.weight / sum * count;
        const bool last = &x == &particles_.back();
        for (; drawn.size() < particles_.size() && (next < reached || last); next += 1) {
            drawn.push_back({.motion = x.motion, .log_weight = 0, .weight = 1, .mean = {}, .covariance = {}});
            drawn_states.insert(drawn_states.end(), x.mean, x.mean + size);
        }
    }
    particles_ = std::move(drawn);
    states_ = std::move(drawn_states);
    point();
}

Estimate MotionParticles::at(double dt_s) const {
    std::array<ForceFlow, rest + 1> by;
    for (std::size_t motion = 0; motion < rest; ++motion)
        by[motion] = afferent::flow(parameters_, motion, dt_s);
    double sum = 0;
    double mean_n = 0;
    double square = 0;
    for (const Particle& x : particles_) {
        sum += x.weight;
        const ForceFlow& flow = by[static_cast<std::size_t>(x.motion)];
        const double force_n = flow.a * x.mean[force] + flow.b * x.mean[speed];
        const double* const p = x.covariance;
        const double variance = flow.a * flow.a * p[0] + 2 * flow.a * flow.b * p[1] +
                                flow.b * flow.b * p[variables_ + 1] + flow.ff;
        mean_n += x.weight * force_n;
        square += x.weight * (force_n * force_n + variance);
    }
    mean_n /= sum;
    return {.force_n = std::max(mean_n, 0.0),
            .sigma_n = std::sqrt(std::max(square / sum - mean_n * mean_n, 0.0))};
}

}  // namespace afferent
