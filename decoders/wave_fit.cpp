#include "afferent/decoders/wave_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr double lag_s = 0.5e-3;
constexpr double steps_a_hertz_second = 4;  // of frequency, in the resolution of the window

double hann(double time_s, double window_s) noexcept {
    const double sine = std::sin(std::numbers::pi * time_s / window_s);
    return sine * sine;
}

}  // namespace

WaveFit::WaveFit(const std::vector<SkinField>& fields, Duration window)
    : fields_(fields), window_s_(seconds(window)) {
    require(fields.size() >= 2, "afferents", "at least 2", static_cast<double>(fields.size()));
    require(window >= 20ms && window <= 4s, "window", "20 ms to 4 s", window_s_);
    double low_x = fields[0].x_mm, high_x = low_x, low_y = fields[0].y_mm, high_y = low_y, variance = 0;
    for (const SkinField& field : fields) {
        low_x = std::min(low_x, field.x_mm);
        high_x = std::max(high_x, field.x_mm);
        low_y = std::min(low_y, field.y_mm);
        high_y = std::max(high_y, field.y_mm);
        variance += field.variance_mm2 / static_cast<double>(fields.size());
    }
    const double longest = std::hypot(high_x - low_x, high_y - low_y);
    require(longest > 0 && variance > 0, "afferents", "at different places, with fields", longest);
    most_per_mm_ = widest_field / std::sqrt(variance);
    // Skin that is very narrow one way does not tell waves along that way apart.
    const auto step = [&](double extent) { return std::numbers::pi / std::max(extent, longest / 8); };
    step_x_per_mm_ = step(high_x - low_x);
    step_y_per_mm_ = step(high_y - low_y);
    // A wave that is longer than the skin is a motion of all of it.
    least_per_mm_ = turn / longest;
    const auto steps = static_cast<std::size_t>(std::lround(steps_a_hertz_second * window_s_ / lag_s));
    cosines_.resize(steps);
    for (std::size_t i = 0; i < steps; ++i)
        cosines_[i] = std::cos(turn * static_cast<double>(i) / static_cast<double>(steps));
    lags_.resize(static_cast<std::size_t>(window_s_ / lag_s) + 1);
    powers_.resize(static_cast<std::size_t>(highest_hz * steps_a_hertz_second * window_s_) + 1);
    frequencies_.reserve(most_frequencies + 1);
    tapered_.resize(fields.size());
    turned_.resize(fields.size());
    turn_.resize(fields.size());
    const double cells = std::numbers::pi * most_per_mm_ * most_per_mm_ / (step_x_per_mm_ * step_y_per_mm_);
    bound_ = std::log(std::max(1.0, cells) * most_frequencies / false_alarm);
}

void WaveFit::operator()(const SpikeTrains& trains, TextureEstimate& estimate) noexcept {
    add_lags(trains);
    find_frequencies();
    Found best;
    for (const std::size_t frequency : frequencies_) {
        const double radians_per_s =
            turn * static_cast<double>(frequency) / (static_cast<double>(cosines_.size()) * lag_s);
        taper(trains, radians_per_s);
        const Found found = best_at(radians_per_s);
        if (found.z > best.z) best = found;
    }
    if (!(best.z > bound_)) return;
    best = fundamental_of(trains, best);
    SmallMatrix<unknowns> covariance;
    Wave wave = best.wave;
    if (!refine(trains, wave, covariance)) return;
    if (wave.radians_per_s < turn * fewest_periods / window_s_) return;
    correct_for_pressure(trains, wave, covariance);
    estimate.oscillates = true;
    estimate.frequency_hz = wave.radians_per_s / turn;
    estimate.frequency_sigma_hz = std::sqrt(covariance[0][0]) / turn;
    const double k = std::hypot(wave.x_per_mm, wave.y_per_mm);
    if (k < least_per_mm_) return;
    const double cos = wave.x_per_mm / k, sin = wave.y_per_mm / k;
    // The standard deviation of the linear combination of ω and k with these coefficients.
    const auto sigma = [&](double of_omega, double of_x, double of_y) {
        const double by[3]{of_omega, of_x, of_y};
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) sum += by[i] * by[j] * covariance[i][j];
        return std::sqrt(std::max(0.0, sum));
    };
    const double relative = sigma(0, cos / k, sin / k);
    if (!(relative < 0.25)) return;
    estimate.slides = true;
    estimate.period_mm = turn / k;
    estimate.period_sigma_mm = estimate.period_mm * relative;
    constexpr double degrees = 360 / turn;
    estimate.direction_deg = std::atan2(sin, cos) * degrees;
    if (estimate.direction_deg < 0) estimate.direction_deg += 360;
    estimate.direction_sigma_deg = sigma(0, -sin / k, cos / k) * degrees;
    const double omega = wave.radians_per_s;
    estimate.speed_mm_per_s = omega / k;
    estimate.speed_sigma_mm_per_s = estimate.speed_mm_per_s * sigma(1 / omega, -cos / k, -sin / k);
}

// Σ |c_i(ω)|² is the cosine transform of the times between the spikes of an afferent.
void WaveFit::add_lags(const SpikeTrains& trains) noexcept {
    std::fill(lags_.begin(), lags_.end(), 0);
    double weights[static_cast<std::size_t>(4 * SpikeTrains::fastest_hz) + 1];
    for (std::size_t i = 0; i < trains.afferents(); ++i) {
        const auto train = trains.of(i);
        for (std::size_t a = 0; a < train.size(); ++a) {
            weights[a] = hann(train[a] * 1e-9, window_s_);
            lags_[0] += weights[a] * weights[a];
            for (std::size_t b = 0; b < a; ++b) {
                const auto lag =
                    static_cast<std::size_t>(std::lround((train[a] - train[b]) * (1e-9 / lag_s)));
                lags_[std::min(lag, lags_.size() - 1)] += 2 * weights[a] * weights[b];
            }
        }
    }
}

double WaveFit::power(std::size_t frequency) const noexcept {
    double sum = 0;
    std::size_t at = 0;
    for (const double lag : lags_) {
        sum += lag * cosines_[at];
        at += frequency;
        if (at >= cosines_.size()) at -= cosines_.size();
    }
    return sum;
}

void WaveFit::find_frequencies() noexcept {
    const auto first = static_cast<std::size_t>(fewest_periods * steps_a_hertz_second);
    for (std::size_t i = first - 1; i < powers_.size(); ++i) powers_[i] = power(i);
    frequencies_.clear();
    for (std::size_t i = first; i + 1 < powers_.size(); ++i) {
        if (powers_[i] < powers_[i - 1] || powers_[i] <= powers_[i + 1]) continue;
        const auto lower = std::find_if(frequencies_.begin(), frequencies_.end(),
                                        [&](std::size_t other) { return powers_[other] < powers_[i]; });
        frequencies_.insert(lower, i);
        if (frequencies_.size() > most_frequencies) frequencies_.pop_back();
    }
}

void WaveFit::taper(const SpikeTrains& trains, double radians_per_s) noexcept {
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        Complex sum;
        for (const std::uint32_t time_ns : trains.of(i)) {
            const double time_s = time_ns * 1e-9;
            const double weight = hann(time_s, window_s_);
            sum.re += weight * std::cos(radians_per_s * time_s);
            sum.im += weight * std::sin(radians_per_s * time_s);
        }
        tapered_[i] = sum;
    }
}

double WaveFit::coherence(double x_per_mm, double y_per_mm) const noexcept {
    double re = 0, im = 0, squares = 0;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        const Complex& c = tapered_[i];
        const double phase = x_per_mm * fields_[i].x_mm + y_per_mm * fields_[i].y_mm;
        const double cos = std::cos(phase), sin = std::sin(phase);
        re += c.re * cos + c.im * sin;
        im += c.im * cos - c.re * sin;
        squares += c.re * c.re + c.im * c.im;
    }
    return squares > 0 ? (re * re + im * im) / squares : 0;
}

// On a grid of wave vectors, row by row: along a row each afferent's phase turns by the same angle a step.
WaveFit::Found WaveFit::best_at(double radians_per_s) noexcept {
    double squares = 0;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        squares += tapered_[i].re * tapered_[i].re + tapered_[i].im * tapered_[i].im;
        const double angle = step_x_per_mm_ * fields_[i].x_mm;
        turn_[i] = {std::cos(angle), -std::sin(angle)};
    }
    Found best{.wave = {.radians_per_s = radians_per_s}, .z = 0};
    if (!(squares > 0)) return best;
    const auto rows = static_cast<int>(most_per_mm_ / step_y_per_mm_);
    for (int row = -rows; row <= rows; ++row) {
        const double y_per_mm = row * step_y_per_mm_;
        const auto columns =
            static_cast<int>(std::sqrt(most_per_mm_ * most_per_mm_ - y_per_mm * y_per_mm) / step_x_per_mm_);
        for (std::size_t i = 0; i < fields_.size(); ++i) {
            const double phase = -columns * step_x_per_mm_ * fields_[i].x_mm + y_per_mm * fields_[i].y_mm;
            const double cos = std::cos(phase), sin = std::sin(phase);
            turned_[i] = {tapered_[i].re * cos + tapered_[i].im * sin,
                          tapered_[i].im * cos - tapered_[i].re * sin};
        }
        for (int column = -columns; column <= columns; ++column) {
            double re = 0, im = 0;
            for (std::size_t i = 0; i < fields_.size(); ++i) {
                Complex& c = turned_[i];
                re += c.re;
                im += c.im;
                c = {c.re * turn_[i].re - c.im * turn_[i].im, c.re * turn_[i].im + c.im * turn_[i].re};
            }
            const double z = (re * re + im * im) / squares;
            if (z > best.z) best = {{radians_per_s, column * step_x_per_mm_, y_per_mm}, z};
        }
    }
    return best;
}

// A lower wave is a part of what has been found, and more of a wave than a motion of the whole skin is: what
// leaks from other frequencies of trains that are in phase is neither.
WaveFit::Found WaveFit::fundamental_of(const SpikeTrains& trains, Found found) noexcept {
    const double significant = std::log(10 / false_alarm);
    constexpr double least_part = 0.25;
    for (;;) {
        Found lower;
        for (const int part : {2, 3}) {
            const Wave slower{found.wave.radians_per_s / part, found.wave.x_per_mm / part,
                              found.wave.y_per_mm / part};
            if (slower.radians_per_s * window_s_ < turn) continue;
            taper(trains, slower.radians_per_s);
            const double z = coherence(slower.x_per_mm, slower.y_per_mm);
            if (z > std::max({lower.z, significant, least_part * found.z, coherence(0, 0)}))
                lower = {slower, z};
        }
        if (lower.z == 0) return found;
        found = lower;
    }
}

WaveFit::Sums WaveFit::sums(const SpikeTrains& trains, const Wave& wave, double phase) noexcept {
    Sums all;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        const auto train = trains.of(i);
        if (train.empty()) continue;
        ++all.afferents;
        const double x = fields_[i].x_mm, y = fields_[i].y_mm;
        const double lag = wave.x_per_mm * x + wave.y_per_mm * y + phase;
        double cosines[3]{}, sines[3]{};  // times 1, t and t²
        for (const std::uint32_t time_ns : train) {
            const double time_s = time_ns * 1e-9 - window_s_ / 2;
            const double angle = wave.radians_per_s * time_s - lag;
            double cos = std::cos(angle), sin = std::sin(angle);
            for (int power = 0; power < 3; ++power, cos *= time_s, sin *= time_s) {
                cosines[power] += cos;
                sines[power] += sin;
            }
        }
        // The angle's derivatives are (t, -x, -y, -1).
        const SmallVector<unknowns> score{-sines[1], x * sines[0], y * sines[0], sines[0]};
        const SmallVector<unknowns> place{0, -x, -y, -1};
        all.cosines += cosines[0];
        for (std::size_t a = 0; a < unknowns; ++a) {
            all.gradient[a] += score[a];
            for (std::size_t b = 0; b <= a; ++b) {
                all.scores[a][b] += score[a] * score[b];
                all.hessian[a][b] += a == 0   ? cosines[2]
                                     : b == 0 ? place[a] * cosines[1]
                                              : place[a] * place[b] * cosines[0];
            }
        }
    }
    return all;
}

bool WaveFit::refine(const SpikeTrains& trains, Wave& wave, SmallMatrix<unknowns>& covariance) noexcept {
    double phase = 0;
    {
        // The best phase for the wave that has been found.
        const Sums even = sums(trains, wave, 0);
        phase = std::atan2(even.gradient[3], even.cosines);
    }
    constexpr int steps = 8;
    for (int step = 0;; ++step) {
        Sums at = sums(trains, wave, phase);
        if (at.afferents <= unknowns || !factor(at.hessian)) return false;
        if (step == steps) {
            const SmallMatrix<unknowns> bread = inverse(at.hessian);
            const double n = static_cast<double>(at.afferents);
            for (std::size_t a = 0; a < unknowns; ++a)
                for (std::size_t b = 0; b < a; ++b) at.scores[b][a] = at.scores[a][b];
            for (std::size_t a = 0; a < unknowns; ++a)
                for (std::size_t b = 0; b < unknowns; ++b) {
                    double sum = 0;
                    for (std::size_t c = 0; c < unknowns; ++c)
                        for (std::size_t d = 0; d < unknowns; ++d)
                            sum += bread[a][c] * at.scores[c][d] * bread[d][b];
                    covariance[a][b] = sum * n / (n - unknowns);
                }
            return true;
        }
        const SmallVector<unknowns> by = solve(at.hessian, at.gradient);
        wave.radians_per_s += by[0];
        wave.x_per_mm += by[1];
        wave.y_per_mm += by[2];
        phase += by[3];
    }
}

// The modulation that a field reads is that at x + s² ∇ ln p, which for a linear gradient is
// x − B (x − x̄), B = fall_off s² V⁻¹: as if the wave vector were (1 − B) k.
void WaveFit::correct_for_pressure(const SpikeTrains& trains, Wave& wave,
                                   SmallMatrix<unknowns>& covariance) const noexcept {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, variance = 0;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        const auto spikes = static_cast<double>(trains.of(i).size());
        const SkinField& field = fields_[i];
        n += spikes;
        x += spikes * field.x_mm;
        y += spikes * field.y_mm;
        xx += spikes * field.x_mm * field.x_mm;
        xy += spikes * field.x_mm * field.y_mm;
        yy += spikes * field.y_mm * field.y_mm;
        variance += spikes * field.variance_mm2;
    }
    xx = xx / n - x * x / (n * n);
    xy = xy / n - x * y / (n * n);
    yy = yy / n - y * y / (n * n);
    // V is at least as wide as a field: a narrower contact has no gradient that the fields could resolve.
    variance /= n;
    xx += variance;
    yy += variance;
    const double determinant = xx * yy - xy * xy;
    // V⁻¹ k, in units of 1/s².
    const double by_x = variance * (yy * wave.x_per_mm - xy * wave.y_per_mm) / determinant;
    const double by_y = variance * (xx * wave.y_per_mm - xy * wave.x_per_mm) / determinant;
    wave.x_per_mm += fall_off * by_x;
    wave.y_per_mm += fall_off * by_y;
    const double by[unknowns]{0, fall_off_sigma * by_x, fall_off_sigma * by_y, 0};
    for (std::size_t a = 0; a < unknowns; ++a)
        for (std::size_t b = 0; b < unknowns; ++b) covariance[a][b] += by[a] * by[b];
}

std::size_t WaveFit::heap_bytes() const noexcept {
    return fields_.capacity() * sizeof(SkinField) +
           (cosines_.capacity() + lags_.capacity() + powers_.capacity()) * sizeof(double) +
           frequencies_.capacity() * sizeof(std::size_t) +
           (tapered_.capacity() + turned_.capacity() + turn_.capacity()) * sizeof(Complex);
}

}  // namespace afferent
