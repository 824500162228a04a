#include "afferent/decoders/force_belief.hpp"

#include <cassert>
#include <cmath>
#include <limits>

#include "afferent/decoders/truncated_normal.hpp"

namespace afferent {
namespace {

using Motion = ForceMotion;

enum : std::size_t { force, speed, first_element };

// The least weight of a motion, from which it can come back within some measurements.
constexpr double least_weight = 1e-6;
// The expectation of a motion of less weight is ignored.
constexpr double expected_weight = 1e-3;
constexpr double rest_variance_n2_per_s2 = 1;

// A bound is soft by this variance, and is ignored if it is so many standard deviations away.
constexpr double softness_n2 = 1e-4;
constexpr double no_cut = 5;
// The logarithm of how probable it is that a bound is wrong.
constexpr double log_wrong_bound = -4.6;
// An element reads no less than nothing.
constexpr double least_departure = -1;

// The variance by which the speed of a motion changes within the lag.
double changed_n2_per_s2(const Motion& motion, double lag_s) {
    return motion.speed_n_per_s * motion.speed_n_per_s * 2 * lost_fraction(lag_s / motion.time_s);
}

// The variance by which a motion strays from a straight line within the lag.
double strayed_n2(const Motion& motion, double lag_s) {
    return motion.speed_n_per_s * motion.speed_n_per_s / motion.time_s * lag_s * lag_s * lag_s / 3;
}

}  // namespace

// The force that a view names, linearised at the mean of a Gaussian: reads (F − lag V) + past_n e.
class ForceBelief::Reading {
  public:
    Reading(const Gaussian& x, const View& view) noexcept
        : covariance_(x.covariance.data()),
          size_(x.mean.size()),
          lag_s_(view.lag_s),
          past_n_(x.mean[force] - view.lag_s * x.mean[speed]),
          has_element_(view.element != View::of_grip),
          element_(has_element_ ? first_element + view.element : force),
          reads_(has_element_ ? 1 + x.mean[element_] : 1) {}

    double mean() const noexcept { return reads_ * past_n_; }
    // The covariance with a component of the Gaussian.
    double with(std::size_t component) const noexcept {
        const double* row = covariance_ + component * size_;
        return reads_ * (row[force] - lag_s_ * row[speed]) + (has_element_ ? past_n_ * row[element_] : 0);
    }
    double variance() const noexcept {
        return reads_ * (with(force) - lag_s_ * with(speed)) + (has_element_ ? past_n_ * with(element_) : 0);
    }

  private:
    const double* covariance_;
    std::size_t size_;
    double lag_s_, past_n_;
    bool has_element_;
    std::size_t element_;
    double reads_;
};

// The mean and variance of a linear function of a Gaussian, and its covariance with each component.
class ForceBelief::Projection {
  public:
    // The quantity that the view names; `variance_n2` is added to its variance.
    Projection(const Gaussian& x, const View& view, double variance_n2) noexcept : size_(x.mean.size()) {
        const Reading reading(x, view);
        for (std::size_t i = 0; i < size_; ++i) with_[i] = reading.with(i);
        mean = reading.mean();
        variance = reading.variance() + variance_n2;
    }
    // V.
    Projection(const Gaussian& x, double variance_n2_per_s2) noexcept : size_(x.mean.size()) {
        for (std::size_t i = 0; i < size_; ++i) with_[i] = x.covariance[i * size_ + speed];
        mean = x.mean[speed];
        variance = with_[speed] + variance_n2_per_s2;
    }
    // Conditions x on the quantity: its mean moves by `shift`, and its variance becomes `part` of what it
    // was.
    void apply(Gaussian& x, double shift, double part) const noexcept {
        const double taken = (1 - part) / variance;
        for (std::size_t i = 0; i < size_; ++i) {
            x.mean[i] += with_[i] / variance * shift;
            for (std::size_t j = 0; j < size_; ++j)
                x.covariance[i * size_ + j] -= taken * (with_[i] * with_[j]);
        }
        for (std::size_t i = first_element; i < size_; ++i) x.mean[i] = std::max(x.mean[i], least_departure);
    }

    double mean, variance;

  private:
    std::size_t size_;
    std::array<double, first_element + most_elements> with_{};
};

ForceBelief::ForceBelief(const Parameters& parameters, const ElementSpread& spread, double largest_n)
    : parameters_(parameters),
      spread_(spread),
      share_(spread.share),
      size_(first_element + spread.share.size()),
      rest_(0.97) {
    assert(spread.share.size() <= most_elements);
    projected_.assign(size_ * size_, 0);
    project_spread();
    left_rest_.mean.assign(size_, 0);
    left_rest_.covariance.assign(size_ * size_, 0);
    bank_.fill(left_rest_);
    for (std::size_t motion = 0; motion < motions; ++motion) {
        Gaussian& x = bank_[motion];
        const double speed_n_per_s = parameters.motion[motion].speed_n_per_s;
        x.covariance[force * size_ + force] = largest_n * largest_n / 4;
        x.covariance[speed * size_ + speed] = speed_n_per_s * speed_n_per_s;
        for (std::size_t i = first_element; i < size_; ++i)
            for (std::size_t j = first_element; j < size_; ++j)
                x.covariance[i * size_ + j] = this->spread(i, j, 1);
        x.weight = (1 - rest_) / static_cast<double>(bank_.size());
    }
    mixed_ = bank_;
}

void ForceBelief::presume_rest(double weight) noexcept {
    for (Gaussian& x : bank_) x.weight *= (1 - weight) / (1 - rest_);
    rest_ = weight;
}

// The prior covariance of e_i and e_j, projected by (I − 1 sᵀ)(I − s 1ᵀ) so that Σ share_i e_i stays 0: a
// departure common to all elements could not be told from a force.
double ForceBelief::spread(std::size_t i, std::size_t j, double wander) const noexcept {
    return (spread_.gain_variance + wander * spread_.share_variance) * projected_[i * size_ + j];
}

void ForceBelief::project_spread() noexcept {
    double squared_shares = 0;
    for (const double share : share_) squared_shares += share * share;
    for (std::size_t i = first_element; i < size_; ++i)
        for (std::size_t j = first_element; j < size_; ++j) {
            const double equal = i == j ? 1 : 0;
            const double one = share_[i - first_element];
            const double other = share_[j - first_element];
            projected_[i * size_ + j] = one > 0 && other > 0 ? equal - one - other + squared_shares : equal;
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

// The mixture for each motion is replaced by a Gaussian with the same moments.
void ForceBelief::mix(const double (&share)[motions + 1][motions]) noexcept {
    const auto source = [&](std::size_t i) -> const Gaussian& { return i < motions ? bank_[i] : left_rest_; };
    for (std::size_t j = 0; j < motions; ++j) {
        Gaussian& mixed = mixed_[j];
        mixed.weight = 0;
        for (std::size_t i = 0; i <= motions; ++i) mixed.weight += share[i][j];
        if (!(mixed.weight > 0)) {
            mixed.mean = bank_[j].mean;
            mixed.covariance = bank_[j].covariance;
            continue;
        }
        std::fill(mixed.mean.begin(), mixed.mean.end(), 0);
        std::fill(mixed.covariance.begin(), mixed.covariance.end(), 0);
        for (std::size_t i = 0; i <= motions; ++i)
            for (std::size_t k = 0; k < size_; ++k)
                mixed.mean[k] += share[i][j] / mixed.weight * source(i).mean[k];
        for (std::size_t i = 0; i <= motions; ++i) {
            const double part = share[i][j] / mixed.weight;
            if (!(part > 0)) continue;
            const Gaussian& x = source(i);
            std::array<double, first_element + most_elements> away;
            for (std::size_t k = 0; k < size_; ++k) away[k] = x.mean[k] - mixed.mean[k];
            for (std::size_t k = 0; k < size_; ++k) {
                double* row = &mixed.covariance[k * size_];
                const double* of = &x.covariance[k * size_];
                for (std::size_t l = 0; l <= k; ++l) row[l] += part * (of[l] + away[k] * away[l]);
            }
        }
        for (std::size_t k = 0; k < size_; ++k)
            for (std::size_t l = 0; l < k; ++l)
                mixed.covariance[l * size_ + k] = mixed.covariance[k * size_ + l];
    }
    std::swap(bank_, mixed_);
}

void ForceBelief::flow(Gaussian& x, const ForceFlow& by) const noexcept {
    const double force_n = x.mean[force];
    const double speed_n_per_s = x.mean[speed];
    x.mean[force] = by.a * force_n + by.b * speed_n_per_s;
    x.mean[speed] = by.c * force_n + by.d * speed_n_per_s;
    double* f = &x.covariance[force * size_];
    double* v = &x.covariance[speed * size_];
    const double ff = f[force], fv = f[speed], vv = v[speed];
    f[force] = by.a * by.a * ff + 2 * by.a * by.b * fv + by.b * by.b * vv + by.ff;
    f[speed] = v[force] = by.a * by.c * ff + (by.a * by.d + by.b * by.c) * fv + by.b * by.d * vv + by.fv;
    v[speed] = by.c * by.c * ff + 2 * by.c * by.d * fv + by.d * by.d * vv + by.vv;
    for (std::size_t i = first_element; i < size_; ++i) {
        const double fe = f[i], ve = v[i];
        f[i] = x.covariance[i * size_ + force] = by.a * fe + by.b * ve;
        v[i] = x.covariance[i * size_ + speed] = by.c * fe + by.d * ve;
    }
}

// The e_i return to 0 so slowly that the shares diffuse as stated, and towards their spread.
void ForceBelief::wander(Gaussian& x, double dt_s, double wander) const noexcept {
    if (spread_.share.empty()) return;
    const double shares = wander * spread_.share_variance;
    const double by_shares = shares / (shares + spread_.gain_variance) / spread_.share_time_s;
    const double lost = lost_fraction(dt_s * std::max(by_shares, 1 / gain_time_s));
    const double variance = spread_.gain_variance + shares;
    for (std::size_t i = first_element; i < size_; ++i) {
        x.mean[i] *= 1 - lost;
        for (std::size_t j = 0; j < first_element; ++j)
            x.covariance[i * size_ + j] = x.covariance[j * size_ + i] *= 1 - lost;
        double* row = &x.covariance[i * size_];
        const double* projected = &projected_[i * size_];
        for (std::size_t j = first_element; j < size_; ++j)
            row[j] += lost * (2 - lost) * (variance * projected[j] - row[j]);
    }
}

void ForceBelief::predict(double dt_s, double wander) noexcept {
    if (!(dt_s > 0)) return;
    double share[motions + 1][motions];
    for (std::size_t i = 0; i < motions; ++i) {
        const Gaussian& x = bank_[i];
        const double releases =
            i == release ? 0 : lost_fraction(parameters_.releases_per_s(x.mean[force], x.mean[speed]) * dt_s);
        const double leaves = lost_fraction(parameters_.motion[i].leaves_per_s * dt_s);
        for (std::size_t j = 0; j < motions; ++j)
            share[i][j] = x.weight * (1 - releases) * (i == j ? 1 - leaves : leaves * becomes[i][j]);
        share[i][release] += x.weight * releases;
    }
    const double from_rest = rest_ * lost_fraction(parameters_.leaves_rest_per_s * dt_s);
    for (std::size_t j = 0; j < motions; ++j) share[motions][j] = j == contact ? from_rest : 0;
    rest_ -= from_rest;

    // A force that leaves rest inherits the departures that the motions have learned.
    const double contact_speed = parameters_.motion[contact].speed_n_per_s;
    const Gaussian& known = bank_[contact];
    for (std::size_t i = first_element; i < size_; ++i) {
        left_rest_.mean[i] = known.mean[i];
        for (std::size_t j = first_element; j < size_; ++j)
            left_rest_.covariance[i * size_ + j] = known.covariance[i * size_ + j];
    }
    left_rest_.covariance[force * size_ + force] = contact_variance_n2;
    left_rest_.covariance[speed * size_ + speed] = contact_speed * contact_speed;

    mix(share);
    for (std::size_t j = 0; j < motions; ++j) {
        flow(bank_[j], afferent::flow(parameters_, j, dt_s));
        this->wander(bank_[j], dt_s, wander);
    }
    normalise();
}

void ForceBelief::measure(double force_n, const View& view, double variance_n2, double together) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    const auto of = [&](double error_n, double z_n2) {
        return Likelihood{-0.5 * error_n * error_n / z_n2 / together, std::pow(z_n2, -0.5 / together)};
    };
    for (std::size_t i = 0; i < motions; ++i) {
        const Projection z(bank_[i], view, variance_n2 + strayed_n2(parameters_.motion[i], view.lag_s));
        likelihood[i] = of(force_n - z.mean, z.variance);
        z.apply(bank_[i], force_n - z.mean, 0);
    }
    likelihood[motions] = of(force_n, rest_variance_n2 + variance_n2);
    weigh(likelihood);
}

double ForceBelief::misfit(double force_n, const View& view, double variance_n2) const noexcept {
    double least = rest_ < expected_weight ? std::numeric_limits<double>::infinity()
                                           : force_n * force_n / (rest_variance_n2 + variance_n2);
    for (std::size_t i = 0; i < motions; ++i) {
        if (bank_[i].weight < expected_weight) continue;
        const Reading reading(bank_[i], view);
        const double error_n = force_n - reading.mean();
        least = std::min(
            least, error_n * error_n /
                       (reading.variance() + variance_n2 + strayed_n2(parameters_.motion[i], view.lag_s)));
    }
    return least;
}

// By moment matching. A bound may be wrong: a motion of which next to nothing lies below it is left as it is.
void ForceBelief::bound(double bound_n, const View& view) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Reading reading(bank_[i], view);
        const double sigma = std::sqrt(reading.variance() + softness_n2);
        const double highest = (std::max(bound_n, 1e-3) - reading.mean()) / sigma;
        if (highest > no_cut) continue;
        const TruncatedNormal cut = truncated_normal(-1e6, highest);
        likelihood[i].exponent = std::max(cut.log_mass, log_wrong_bound);
        if (!(cut.log_mass > log_wrong_bound)) continue;
        const Projection z(bank_[i], view, softness_n2);
        z.apply(bank_[i], sigma * cut.mean, cut.variance);
    }
    weigh(likelihood);
    keep_positive();
}

void ForceBelief::keep_positive() noexcept {
    for (std::size_t i = 0; i < motions; ++i) {
        Gaussian& x = bank_[i];
        const double sigma = std::sqrt(x.covariance[force * size_ + force] + softness_n2);
        if (x.mean[force] > no_cut * sigma) continue;
        const Projection z(x, View{}, softness_n2);
        const TruncatedNormal cut = truncated_normal(-z.mean / sigma, 1e6);
        z.apply(x, sigma * cut.mean, cut.variance);
        if (i == hold) continue;
        const double above = std::exp(cut.log_mass);
        rest_ += x.weight * (1 - above);
        x.weight *= above;
    }
    normalise();
}

// A reading at full scale is certain, unlike a silence: a motion that contradicts it gets no benefit of the
// doubt.
void ForceBelief::bound_below(double bound_n, const View& view) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Projection z(bank_[i], view, softness_n2 + strayed_n2(parameters_.motion[i], view.lag_s));
        const double sigma = std::sqrt(z.variance);
        const double lowest = (bound_n - z.mean) / sigma;
        // Where other elements measure a larger force, cutting again would only push the mean up.
        if (lowest < -1) continue;
        const TruncatedNormal cut = truncated_normal(lowest, 1e6);
        likelihood[i].exponent = cut.log_mass;
        z.apply(bank_[i], sigma * cut.mean, cut.variance);
    }
    likelihood[motions].exponent = -0.5 * bound_n * bound_n / rest_variance_n2;
    weigh(likelihood);
}

void ForceBelief::measure_speed(double speed_n_per_s, double lag_s, double variance_n2_per_s2) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Projection z(bank_[i], variance_n2_per_s2 + changed_n2_per_s2(parameters_.motion[i], lag_s));
        // A transient afferent cannot tell the sign of the speed; it is taken from the motion.
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
        const Projection z(bank_[i], changed_n2_per_s2(parameters_.motion[i], lag_s));
        const double sigma = std::sqrt(z.variance);
        const TruncatedNormal cut =
            truncated_normal((-bound_n_per_s - z.mean) / sigma, (bound_n_per_s - z.mean) / sigma);
        z.apply(bank_[i], sigma * cut.mean, cut.variance);
        likelihood[i].exponent = cut.log_mass;
    }
    weigh(likelihood);
}

void ForceBelief::bound_speed_below(double bound_n_per_s) noexcept {
    std::array<Likelihood, motions + 1> likelihood;
    for (std::size_t i = 0; i < motions; ++i) {
        const Projection z(bank_[i], 0);
        const double sigma = std::sqrt(z.variance);
        const TruncatedNormal cut = truncated_normal((bound_n_per_s - z.mean) / sigma, 1e6);
        likelihood[i].exponent = std::max(cut.log_mass, log_wrong_bound);
        if (cut.log_mass > log_wrong_bound) z.apply(bank_[i], sigma * cut.mean, cut.variance);
    }
    weigh(likelihood);
}

// The readings of the other elements stay, and F remains the sum of all: along the direction in which e_i
// moves by 1 − share, all other e move by −share, and F by share.
void ForceBelief::widen(std::uint32_t element, double variance) noexcept {
    const double share = share_[element];
    for (Gaussian& x : bank_) {
        std::array<double, first_element + most_elements> along{x.mean[force] * share, x.mean[speed] * share};
        for (std::size_t i = first_element; i < size_; ++i)
            along[i] = (i == first_element + element ? 1 : 0) - share;
        for (std::size_t i = 0; i < size_; ++i)
            for (std::size_t j = 0; j < size_; ++j)
                x.covariance[i * size_ + j] += variance * along[i] * along[j];
    }
}

void ForceBelief::loosen(double wander) noexcept {
    for (Gaussian& x : bank_)
        for (std::size_t i = first_element; i < size_; ++i)
            for (std::size_t j = first_element; j < size_; ++j)
                x.covariance[i * size_ + j] += spread(i, j, wander) - spread(i, j, 0);
}

void ForceBelief::exclude(std::uint32_t element) noexcept { share_among(element, 0); }
void ForceBelief::include(std::uint32_t element) noexcept { share_among(element, spread_.share[element]); }

// The reading of each element stays, and F becomes the sum over those that are not excluded: with m = Σ
// share_i e_i,
//     F' = F (1 + m),      V' = V (1 + m),      1 + e_i' = (1 + e_i)/(1 + m)
// and the covariance by its linear part.
void ForceBelief::share_among(std::uint32_t element, double share) noexcept {
    const double others = 1 - share_[element];
    if (!(others > 0)) return;
    double given = share;
    for (std::size_t i = 0; i < share_.size(); ++i)
        if (i != element && share_[i] > 0) given += spread_.share[i];
    share_[element] = share;
    for (std::size_t i = 0; i < share_.size(); ++i)
        if (share_[i] > 0) share_[i] = spread_.share[i] / given;
    project_spread();
    for (Gaussian& x : bank_) {
        const std::size_t own = first_element + element;
        x.mean[own] = 0;
        for (std::size_t i = 0; i < size_; ++i)
            x.covariance[i * size_ + own] = x.covariance[own * size_ + i] = 0;
        x.covariance[own * size_ + own] = spread(own, own, 1);
        std::array<double, first_element + most_elements> along{}, with{};
        along[force] = x.mean[force];
        along[speed] = x.mean[speed];
        double shift = 0, variance = 0;
        for (std::size_t i = first_element; i < size_; ++i) {
            along[i] = share_[i - first_element] > 0 ? -1 : 0;
            shift += share_[i - first_element] * x.mean[i];
            for (std::size_t j = 0; j < size_; ++j)
                with[j] += share_[i - first_element] * x.covariance[i * size_ + j];
        }
        for (std::size_t i = first_element; i < size_; ++i) variance += share_[i - first_element] * with[i];
        for (std::size_t i = 0; i < size_; ++i) {
            x.mean[i] = i < first_element ? x.mean[i] * (1 + shift) : (1 + x.mean[i]) / (1 + shift) - 1;
            for (std::size_t j = 0; j < size_; ++j)
                x.covariance[i * size_ + j] +=
                    along[i] * with[j] + with[i] * along[j] + variance * along[i] * along[j];
        }
    }
}

void ForceBelief::forget_departures() noexcept {
    for (Gaussian& x : bank_)
        for (std::size_t i = first_element; i < size_; ++i) {
            x.mean[i] = 0;
            for (std::size_t j = 0; j < first_element; ++j)
                x.covariance[i * size_ + j] = x.covariance[j * size_ + i] = 0;
            for (std::size_t j = first_element; j < size_; ++j) x.covariance[i * size_ + j] = spread(i, j, 1);
        }
}

ForceBelief::Moments ForceBelief::of_speed() const noexcept {
    double mean = 0;
    double square = 0;
    for (const Gaussian& x : bank_) {
        mean += x.weight * std::abs(x.mean[speed]);
        square += x.weight * (x.covariance[speed * size_ + speed] + x.mean[speed] * x.mean[speed]);
    }
    return {mean, std::max(square - mean * mean, 0.0)};
}

ForceBelief::Moments ForceBelief::of_past(const View& view) const noexcept {
    double mean_n = 0;
    double square_n2 = 0;
    for (const Gaussian& x : bank_) {
        const Reading reading(x, view);
        const double mean = reading.mean();
        mean_n += x.weight * mean;
        square_n2 += x.weight * (reading.variance() + mean * mean);
    }
    return {mean_n, std::max(square_n2 - mean_n * mean_n, 0.0)};
}

ForceBelief::Moments ForceBelief::after(double dt_s) const noexcept {
    double mean_n = 0;
    double square_n2 = 0;
    for (std::size_t i = 0; i < motions; ++i) {
        const Gaussian& x = bank_[i];
        const ForceFlow by = afferent::flow(parameters_, i, dt_s);
        const double mean = by.a * x.mean[force] + by.b * x.mean[speed];
        const double variance = by.a * by.a * x.covariance[force * size_ + force] +
                                2 * by.a * by.b * x.covariance[force * size_ + speed] +
                                by.b * by.b * x.covariance[speed * size_ + speed] + by.ff;
        mean_n += x.weight * mean;
        square_n2 += x.weight * (variance + mean * mean);
    }
    return {mean_n, std::max(square_n2 - mean_n * mean_n, 0.0)};
}

ForceBelief::Moments ForceBelief::of_element(std::uint32_t element) const noexcept {
    double weight = 0, mean = 0, square = 0;
    for (const Gaussian& x : bank_) {
        const double own = x.mean[first_element + element];
        weight += x.weight;
        mean += x.weight * own;
        square += x.weight * (x.covariance[(first_element + element) * (size_ + 1)] + own * own);
    }
    mean /= weight;
    return {mean, std::max(square / weight - mean * mean, 0.0)};
}

std::size_t ForceBelief::heap_bytes() const noexcept {
    return (2 * motions + 1) * (size_ + size_ * size_) * sizeof(double) +
           (spread_.share.capacity() + share_.capacity() + projected_.capacity()) * sizeof(double);
}

}  // namespace afferent
