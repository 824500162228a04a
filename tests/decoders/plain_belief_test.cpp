// A belief of the force against the same mixture of Gaussians, written with whole matrices.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "afferent/decoders/force_belief.hpp"
#include "afferent/decoders/truncated_normal.hpp"

namespace afferent {
namespace {

using Row = std::vector<double>;
using Matrix = std::vector<Row>;

Row times(const Matrix& a, const Row& x) {
    Row result(a.size(), 0);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < x.size(); ++j) result[i] += a[i][j] * x[j];
    return result;
}

double times(const Row& a, const Row& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

Matrix unit(std::size_t size) {
    Matrix result(size, Row(size, 0));
    for (std::size_t i = 0; i < size; ++i) result[i][i] = 1;
    return result;
}

void add(Matrix& to, const Row& a, const Row& b, double factor = 1) {
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j) to[i][j] += factor * a[i] * b[j];
}

// J P Jᵀ
Matrix moved(const Matrix& by, const Matrix& covariance) {
    const std::size_t size = by.size();
    Matrix result(size, Row(size, 0));
    for (std::size_t i = 0; i < size; ++i) {
        const Row with = times(covariance, by[i]);
        for (std::size_t j = 0; j < size; ++j) result[i][j] = times(by[j], with);
    }
    return result;
}

// F, V and the departures of elements of equal sizes; F is the sum of what those read that are included.
class PlainBelief {
  public:
    using Parameters = ForceBeliefParameters;
    using View = ForceBelief::View;
    static constexpr std::size_t motions = Parameters::motions;

    PlainBelief(const Parameters& parameters, const ElementSpread& spread, double largest_n)
        : parameters_(parameters), spread_(spread), share_(spread.share), size_(2 + spread.share.size()) {
        for (std::size_t i = 0; i < motions; ++i) {
            bank_[i] = {Row(size_, 0), Matrix(size_, Row(size_, 0)), 0.03 / motions};
            bank_[i].covariance[0][0] = std::pow(largest_n / 2, 2);
            bank_[i].covariance[1][1] = std::pow(parameters.motion[i].speed_n_per_s, 2);
            reset_departures(bank_[i]);
        }
    }

    void predict(double dt_s, double wander) {
        std::array<Gaussian, motions + 1> from;
        std::copy(bank_.begin(), bank_.end(), from.begin());
        Gaussian& left_rest = from[motions] = bank_[Parameters::contact];
        for (std::size_t i = 0; i < 2; ++i) {
            left_rest.mean[i] = 0;
            for (std::size_t j = 0; j < size_; ++j)
                left_rest.covariance[i][j] = left_rest.covariance[j][i] = 0;
        }
        left_rest.covariance[0][0] = 0.05;
        left_rest.covariance[1][1] = std::pow(parameters_.motion[Parameters::contact].speed_n_per_s, 2);
        left_rest.weight = rest_ * (1 - std::exp(-dt_s * parameters_.leaves_rest_per_s));
        rest_ -= left_rest.weight;
        for (std::size_t j = 0; j < motions; ++j) {
            Row weights(motions + 1, 0);
            for (std::size_t i = 0; i <= motions; ++i)
                weights[i] = from[i].weight * passes(from[i], i, j, dt_s);
            Gaussian& to = bank_[j];
            to = {Row(size_, 0), Matrix(size_, Row(size_, 0)), 0};
            for (const double weight : weights) to.weight += weight;
            for (std::size_t i = 0; i <= motions; ++i)
                for (std::size_t k = 0; k < size_; ++k)
                    to.mean[k] += weights[i] / to.weight * from[i].mean[k];
            for (std::size_t i = 0; i <= motions; ++i) {
                Row away = from[i].mean;
                for (std::size_t k = 0; k < size_; ++k) away[k] -= to.mean[k];
                for (std::size_t k = 0; k < size_; ++k)
                    for (std::size_t l = 0; l < size_; ++l)
                        to.covariance[k][l] +=
                            weights[i] / to.weight * (from[i].covariance[k][l] + away[k] * away[l]);
            }
            let_pass(to, j, dt_s, wander);
        }
        normalise();
    }

    void measure(double force_n, const View& view, double variance_n2, double together) {
        update(
            [&](Gaussian& x, std::size_t motion) {
                const Row along = gradient(x, view);
                const double variance =
                    times(along, times(x.covariance, along)) + variance_n2 + strayed(motion, view);
                const double error = force_n - mean_of(x, view);
                condition(x, along, variance, error, 0);
                return -(error * error / variance + std::log(variance)) / 2 / together;
            },
            -(force_n * force_n / (0.0025 + variance_n2) + std::log(0.0025 + variance_n2)) / 2 / together);
    }

    double misfit(double force_n, const View& view, double variance_n2) const {
        double least = rest_ < 1e-3 ? 1e300 : force_n * force_n / (0.0025 + variance_n2);
        for (std::size_t i = 0; i < motions; ++i) {
            const Row along = gradient(bank_[i], view);
            const double variance =
                times(along, times(bank_[i].covariance, along)) + variance_n2 + strayed(i, view);
            if (bank_[i].weight >= 1e-3)
                least = std::min(least, std::pow(force_n - mean_of(bank_[i], view), 2) / variance);
        }
        return least;
    }

    void bound(double bound_n, const View& view) {
        update(
            [&](Gaussian& x, std::size_t) {
                const Row along = gradient(x, view);
                const double variance = times(along, times(x.covariance, along)) + 1e-4;
                const double highest = (std::max(bound_n, 1e-3) - mean_of(x, view)) / std::sqrt(variance);
                return highest > 5 ? 0 : cut(x, along, variance, -1e6, highest, -4.6);
            },
            0);
        for (std::size_t i = 0; i < motions; ++i) {
            Gaussian& x = bank_[i];
            const double variance = x.covariance[0][0] + 1e-4;
            if (x.mean[0] > 5 * std::sqrt(variance)) continue;
            const double mass =
                std::exp(cut(x, gradient(x, {}), variance, -x.mean[0] / std::sqrt(variance), 1e6, -1e300));
            if (i == Parameters::hold) continue;
            rest_ += (1 - mass) * x.weight;
            x.weight *= mass;
        }
        normalise();
    }

    void bound_below(double bound_n, const View& view) {
        update(
            [&](Gaussian& x, std::size_t motion) {
                const Row along = gradient(x, view);
                const double variance =
                    times(along, times(x.covariance, along)) + 1e-4 + strayed(motion, view);
                const double lowest = (bound_n - mean_of(x, view)) / std::sqrt(variance);
                return lowest < -1 ? 0 : cut(x, along, variance, lowest, 1e6, -1e300);
            },
            -bound_n * bound_n / 0.0025 / 2);
    }

    void measure_speed(double speed, double lag_s, double variance_n2) {
        update(
            [&](Gaussian& x, std::size_t motion) {
                const double variance = x.covariance[1][1] + variance_n2 + changed(motion, lag_s);
                const double error = (x.mean[1] < 0 ? -speed : speed) - x.mean[1];
                condition(x, of_speed_alone(), variance, error, 0);
                return -(error * error / variance + std::log(variance)) / 2;
            },
            -(speed * speed / (1 + variance_n2) + std::log(1 + variance_n2)) / 2);
    }

    void bound_speed(double bound, double lag_s) {
        update(
            [&](Gaussian& x, std::size_t motion) {
                const double variance = x.covariance[1][1] + changed(motion, lag_s);
                return cut(x, of_speed_alone(), variance, (-bound - x.mean[1]) / std::sqrt(variance),
                           (bound - x.mean[1]) / std::sqrt(variance), -1e300);
            },
            0);
    }

    void bound_speed_below(double bound) {
        update(
            [&](Gaussian& x, std::size_t) {
                const double variance = x.covariance[1][1];
                return cut(x, of_speed_alone(), variance, (bound - x.mean[1]) / std::sqrt(variance), 1e6,
                           -4.6);
            },
            0);
    }

    // e_i moves by 1 − share, the others by −share, and F and V by share of themselves.
    void widen(std::uint32_t element, double variance) {
        for (Gaussian& x : bank_) {
            Row along(size_, -share_[element]);
            along[0] = share_[element] * x.mean[0];
            along[1] = share_[element] * x.mean[1];
            along[2 + element] += 1;
            add(x.covariance, along, along, variance);
        }
    }

    void loosen(double wander) {
        for (Gaussian& x : bank_)
            for (std::size_t i = 2; i < size_; ++i)
                for (std::size_t j = 2; j < size_; ++j)
                    x.covariance[i][j] += wander * spread_.share_variance * projected()[i - 2][j - 2];
    }

    void exclude(std::uint32_t element) { set_share(element, 0); }
    void include(std::uint32_t element) { set_share(element, spread_.share[element]); }

    void forget_departures() {
        for (Gaussian& x : bank_) reset_departures(x);
    }

    ForceBelief::Moments of_past(const View& view) const {
        return moments([&](const Gaussian& x, std::size_t) {
            const Row along = gradient(x, view);
            return std::pair(mean_of(x, view), times(along, times(x.covariance, along)));
        });
    }
    ForceBelief::Moments after(double dt_s) const {
        return moments([&](const Gaussian& x, std::size_t motion) {
            Gaussian then = x;
            let_force_pass(then, motion, dt_s);
            return std::pair(then.mean[0], then.covariance[0][0]);
        });
    }
    ForceBelief::Moments of_speed() const {
        return moments([](const Gaussian& x, std::size_t) {
            return std::pair(std::abs(x.mean[1]), x.covariance[1][1]);
        });
    }
    ForceBelief::Moments of_element(std::uint32_t element) const {
        const auto of = moments([&](const Gaussian& x, std::size_t) {
            return std::pair(x.mean[2 + element], x.covariance[2 + element][2 + element]);
        });
        // At rest no element is known, so that only the motions count.
        double all = 0;
        for (const Gaussian& x : bank_) all += x.weight;
        const double square = (of.variance_n2 + of.mean_n * of.mean_n) / all;
        return {of.mean_n / all, square - std::pow(of.mean_n / all, 2)};
    }
    double at_rest() const { return rest_; }
    double releasing() const {
        double all = 0;
        for (const Gaussian& x : bank_) all += x.weight;
        return bank_[Parameters::release].weight / all;
    }

  private:
    struct Gaussian {
        Row mean;
        Matrix covariance;
        double weight;
    };

    // The part of a motion (or of what has left rest) that becomes another one.
    double passes(const Gaussian& x, std::size_t from, std::size_t to, double dt_s) const {
        if (from == motions) return to == Parameters::contact ? 1 : 0;
        const double release = from == Parameters::release
                                   ? 0
                                   : 1 - std::exp(-dt_s * parameters_.releases_per_s(x.mean[0], x.mean[1]));
        const double stays = std::exp(-dt_s * parameters_.motion[from].leaves_per_s);
        const double other = from == to ? stays : (1 - stays) * ForceBelief::becomes[from][to];
        return (1 - release) * other + (to == Parameters::release ? release : 0);
    }

    void let_force_pass(Gaussian& x, std::size_t motion, double dt_s) const {
        const ForceFlow by = flow(parameters_, motion, dt_s);
        Matrix step = unit(size_);
        step[0][0] = by.a;
        step[0][1] = by.b;
        step[1][0] = by.c;
        step[1][1] = by.d;
        x.mean = times(step, x.mean);
        x.covariance = moved(step, x.covariance);
        x.covariance[0][0] += by.ff;
        x.covariance[0][1] += by.fv;
        x.covariance[1][0] += by.fv;
        x.covariance[1][1] += by.vv;
    }

    // Departures decay with the correlation time of shares, as far as they are of shares, or in 10 s if that
    // is sooner; their variance returns to the spread.
    void let_pass(Gaussian& x, std::size_t motion, double dt_s, double wander) const {
        let_force_pass(x, motion, dt_s);
        if (share_.empty()) return;
        const double variance = spread_.gain_variance + wander * spread_.share_variance;
        const double rate = wander * spread_.share_variance / variance / spread_.share_time_s;
        const double kept = std::exp(-dt_s * std::max(rate, 0.1));
        Matrix step = unit(size_);
        for (std::size_t i = 2; i < size_; ++i) step[i][i] = kept;
        x.mean = times(step, x.mean);
        x.covariance = moved(step, x.covariance);
        for (std::size_t i = 2; i < size_; ++i)
            for (std::size_t j = 2; j < size_; ++j)
                x.covariance[i][j] += (1 - kept * kept) * variance * projected()[i - 2][j - 2];
    }

    // (I − 1 sᵀ)(I − s 1ᵀ) over those that are included
    Matrix projected() const {
        Matrix out = unit(share_.size());
        for (std::size_t i = 0; i < share_.size(); ++i)
            for (std::size_t j = 0; j < share_.size(); ++j) out[i][j] -= share_[i] > 0 ? share_[j] : 0;
        return moved(out, unit(share_.size()));
    }

    void reset_departures(Gaussian& x) const {
        const Matrix spread = projected();
        for (std::size_t i = 2; i < size_; ++i) {
            x.mean[i] = 0;
            for (std::size_t j = 0; j < size_; ++j)
                x.covariance[i][j] = x.covariance[j][i] =
                    j < 2 ? 0 : (spread_.gain_variance + spread_.share_variance) * spread[i - 2][j - 2];
        }
    }

    void set_share(std::uint32_t element, double share) {
        double sum = share;
        for (std::size_t i = 0; i < share_.size(); ++i)
            if (i != element && share_[i] > 0) sum += spread_.share[i];
        share_[element] = share;
        for (std::size_t i = 0; i < share_.size(); ++i)
            if (share_[i] > 0) share_[i] = spread_.share[i] / sum;
        const double alone = (spread_.gain_variance + spread_.share_variance) * projected()[element][element];
        for (Gaussian& x : bank_) {
            const std::size_t own = 2 + element;
            x.mean[own] = 0;
            for (std::size_t i = 0; i < size_; ++i) x.covariance[i][own] = x.covariance[own][i] = 0;
            x.covariance[own][own] = alone;
            // The readings stay. By how much their sum is more than F:
            Row more(size_, 0);
            for (std::size_t i = 0; i < share_.size(); ++i) more[2 + i] = share_[i];
            const double m = times(more, x.mean);
            Matrix step = unit(size_);
            for (std::size_t i = 0; i < size_; ++i) {
                const double along = i < 2 ? x.mean[i] : share_[i - 2] > 0 ? -1 : 0;
                for (std::size_t j = 0; j < size_; ++j) step[i][j] += along * more[j];
            }
            x.covariance = moved(step, x.covariance);
            for (std::size_t i = 0; i < size_; ++i)
                x.mean[i] = i < 2 ? x.mean[i] * (1 + m) : (1 + x.mean[i]) / (1 + m) - 1;
        }
    }

    // (1 + e)(F − lag V)
    static double mean_of(const Gaussian& x, const View& view) {
        const double past = x.mean[0] - view.lag_s * x.mean[1];
        return view.element == View::of_grip ? past : (1 + x.mean[2 + view.element]) * past;
    }
    Row gradient(const Gaussian& x, const View& view) const {
        const double reads = view.element == View::of_grip ? 1 : 1 + x.mean[2 + view.element];
        Row along(size_, 0);
        along[0] = reads;
        along[1] = -view.lag_s * reads;
        if (view.element != View::of_grip) along[2 + view.element] = x.mean[0] - view.lag_s * x.mean[1];
        return along;
    }
    Row of_speed_alone() const {
        Row along(size_, 0);
        along[1] = 1;
        return along;
    }
    double strayed(std::size_t motion, const View& view) const {
        const ForceMotion& of = parameters_.motion[motion];
        return std::pow(of.speed_n_per_s, 2) / of.time_s * std::pow(view.lag_s, 3) / 3;
    }
    double changed(std::size_t motion, double lag_s) const {
        const ForceMotion& of = parameters_.motion[motion];
        return std::pow(of.speed_n_per_s, 2) * 2 * (1 - std::exp(-lag_s / of.time_s));
    }

    // What lies along `along` moves by `shift`, and has `part` of its variance left.
    static void condition(Gaussian& x, const Row& along, double variance, double shift, double part) {
        const Row with = times(x.covariance, along);
        for (std::size_t i = 0; i < with.size(); ++i) x.mean[i] += with[i] * shift / variance;
        add(x.covariance, with, with, -(1 - part) / variance);
        for (std::size_t i = 2; i < with.size(); ++i) x.mean[i] = std::max(x.mean[i], -1.0);
    }
    // Cuts off what is beyond the limits, unless that is all but certain to be wrong. Returns the logarithm
    // of what is left.
    static double cut(Gaussian& x, const Row& along, double variance, double low, double high, double wrong) {
        const TruncatedNormal left = truncated_normal(low, high);
        if (!(left.log_mass > wrong)) return wrong;
        condition(x, along, variance, std::sqrt(variance) * left.mean, left.variance);
        return left.log_mass;
    }

    void update(const std::function<double(Gaussian&, std::size_t)>& of, double log_of_rest) {
        Row logs(motions + 1, log_of_rest);
        for (std::size_t i = 0; i < motions; ++i) logs[i] = of(bank_[i], i);
        const double most = *std::max_element(logs.begin(), logs.end());
        for (std::size_t i = 0; i < motions; ++i) bank_[i].weight *= std::exp(logs[i] - most);
        rest_ *= std::exp(log_of_rest - most);
        normalise();
    }

    // No weight falls below a millionth.
    void normalise() {
        Row weights{rest_};
        for (const Gaussian& x : bank_) weights.push_back(x.weight);
        for (int raise = 0; raise < 2; ++raise) {
            double sum = 0;
            for (const double weight : weights) sum += weight;
            for (double& weight : weights) weight = raise == 0 ? std::max(weight / sum, 1e-6) : weight / sum;
        }
        rest_ = weights[0];
        for (std::size_t i = 0; i < motions; ++i) bank_[i].weight = weights[i + 1];
    }

    ForceBelief::Moments moments(
        const std::function<std::pair<double, double>(const Gaussian&, std::size_t)>& of) const {
        double mean = 0, square = 0;
        for (std::size_t i = 0; i < motions; ++i) {
            const auto [own, variance] = of(bank_[i], i);
            mean += bank_[i].weight * own;
            square += bank_[i].weight * (variance + own * own);
        }
        return {mean, square - mean * mean};
    }

    Parameters parameters_;
    ElementSpread spread_;
    Row share_;
    std::size_t size_;
    std::array<Gaussian, motions> bank_;
    double rest_ = 0.97;
};

// To within the rounding of some hundred products.
void expect_equal(const ForceBelief::Moments& one, const ForceBelief::Moments& other,
                  const std::string& what) {
    ASSERT_NEAR(one.mean_n, other.mean_n, 1e-9 * std::max(1.0, std::abs(other.mean_n))) << what;
    ASSERT_NEAR(one.variance_n2, other.variance_n2, 1e-8 * std::max(1.0, other.variance_n2)) << what;
}

void expect_equal(const ForceBelief& belief, const PlainBelief& plain, std::uint32_t elements,
                  const std::string& what) {
    ASSERT_NEAR(belief.at_rest(), plain.at_rest(), 1e-10) << what;
    ASSERT_NEAR(belief.releasing(), plain.releasing(), 1e-10) << what;
    for (const double lag_s : {0.0, 0.02, -0.05})
        expect_equal(belief.of_past({lag_s}), plain.of_past({lag_s}), what);
    expect_equal(belief.of_speed(), plain.of_speed(), what + ": speed");
    for (const double dt_s : {0.0, 0.007})
        expect_equal(belief.after(dt_s), plain.after(dt_s), what + ": after");
    ASSERT_NEAR(belief.misfit(3, {0.01}, 0.04), plain.misfit(3, {0.01}, 0.04), 1e-7) << what;
    for (std::uint32_t i = 0; i < elements; ++i) {
        expect_equal(belief.of_element(i), plain.of_element(i), what + ": element");
        expect_equal(belief.of_past({0.01, i}), plain.of_past({0.01, i}), what + ": view of an element");
        ASSERT_NEAR(belief.misfit(3, {0.01, i}, 0.04), plain.misfit(3, {0.01, i}, 0.04), 1e-7) << what;
    }
}

// A grasp that rises to 8 N, is held, and is released; everything that can be told of it is told.
TEST(ForceBelief, IsTheMixtureOfGaussiansThatItSays) {
    const ElementSpread alone;
    const ElementSpread three{
        .share = {0.5, 0.3, 0.2}, .gain_variance = 0.0025, .share_variance = 0.0036, .share_time_s = 2};
    for (const ElementSpread& spread : {alone, three}) {
        const auto elements = static_cast<std::uint32_t>(spread.share.size());
        ForceBelief belief({}, spread, 30);
        PlainBelief plain({}, spread, 30);
        std::mt19937 random(5);
        const auto noise = [&](double size) {
            return size * (static_cast<double>(random() % 1000) / 500 - 1);
        };
        const auto both = [&](const char* what, const auto& tell) {
            tell(belief);
            tell(plain);
            expect_equal(belief, plain, elements, what);
        };
        for (int i = 0; i < 120 && !testing::Test::HasFatalFailure(); ++i) {
            const double force_n = i < 40 ? 0.2 * i : i < 80 ? 8 : std::max(0.0, 8 - 0.4 * (i - 80));
            const ForceBelief::View view{
                0.006, elements > 0 ? static_cast<std::uint32_t>(i) % elements : ForceBelief::View::of_grip};
            both("predict", [&, wander = 1 + 0.1 * i](auto& to) { to.predict(0.004, wander); });
            const double told_n = force_n + noise(0.1);
            if (i % 3 != 2) both("measure", [&](auto& to) { to.measure(told_n, view, 0.01, 1 + i % 2); });
            if (i % 4 == 1) both("bound", [&](auto& to) { to.bound(force_n + 0.05, view); });
            if (i % 8 == 3) both("bound_below", [&](auto& to) { to.bound_below(force_n - 0.05, view); });
            if (i % 5 == 2)
                both("measure_speed", [&](auto& to) { to.measure_speed(i < 40 ? 50 : 5, 0.003, 4); });
            if (i % 7 == 4) both("bound_speed", [&](auto& to) { to.bound_speed(60, 0.01); });
            if (i % 6 == 5) both("bound_speed_below", [&](auto& to) { to.bound_speed_below(-120); });
            if (elements == 0) continue;
            if (i % 20 == 9) both("widen", [&](auto& to) { to.widen(i % elements, 0.01); });
            if (i % 20 == 13) both("loosen", [&](auto& to) { to.loosen(0.7); });
            if (i % 40 == 21) both("exclude", [&](auto& to) { to.exclude(1); });
            if (i % 40 == 33) both("include", [&](auto& to) { to.include(1); });
            if (i == 100) both("forget_departures", [&](auto& to) { to.forget_departures(); });
        }
    }
}

}  // namespace
}  // namespace afferent
