#include "afferent/decoders/wave_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr double turn = 2 * std::numbers::pi;
constexpr std::uint32_t lag_ns = 500'000;
constexpr double lag_s = lag_ns / 1e9;
constexpr double steps_a_hertz_second = 4;  // of frequency, in the resolution of the window
constexpr std::size_t powers_at_once = 4;
// A maximum is higher than the power below it, so that this one is below fewest_periods.
constexpr auto first_power = static_cast<std::size_t>(WaveFit::fewest_periods * steps_a_hertz_second) - 1;
constexpr int most_steps = 8;  // of Newton's method

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
    weights_.resize(fields.size() * SpikeTrains::room_in(window));
    tapered_.resize(fields.size());
    turned_.resize(fields.size());
    const auto turns = [&](double step_per_mm, double SkinField::*place) {
        const auto most = static_cast<std::size_t>(most_per_mm_ / step_per_mm);
        std::vector<Complex> all;
        all.reserve((most + 1) * fields.size());
        for (std::size_t k = 0; k <= most; ++k)
            for (const SkinField& field : fields) {
                const double angle = static_cast<double>(k) * step_per_mm * (field.*place);
                all.push_back({std::cos(angle), std::sin(angle)});
            }
        return all;
    };
    column_turns_ = turns(step_x_per_mm_, &SkinField::x_mm);
    row_turns_ = turns(step_y_per_mm_, &SkinField::y_mm);
    const double cells = std::numbers::pi * most_per_mm_ * most_per_mm_ / (step_x_per_mm_ * step_y_per_mm_);
    bound_ = std::log(std::max(1.0, cells) * most_frequencies / false_alarm);
}

void WaveFit::begin() noexcept {
    state_ = {};
    std::fill(lags_.begin(), lags_.end(), 0);
}

bool WaveFit::advance(const SpikeTrains& trains, WorkBudget& budget, TextureEstimate& estimate) noexcept {
    while (state_.stage != Stage::complete && budget.take(next_piece(trains))) do_next(trains, estimate);
    return state_.stage == Stage::complete;
}

// How much work the next piece is.
std::size_t WaveFit::next_piece(const SpikeTrains& trains) const noexcept {
    switch (state_.stage) {
        case Stage::lags:
            return WorkBudget::sine + 2 * state_.spike;
        case Stage::powers:
            return powers_at_once * lags_.size();
        case Stage::taper:
        case Stage::sums:
            return WorkBudget::sine * (1 + trains.of(state_.next).size());
        case Stage::row:
        case Stage::column:
            return 2 * fields_.size();
        case Stage::part:
            return 2 * WorkBudget::sine * fields_.size();
        case Stage::complete:
            break;
    }
    return 0;
}

void WaveFit::do_next(const SpikeTrains& trains, TextureEstimate& estimate) noexcept {
    switch (state_.stage) {
        case Stage::lags:
            return add_lags(trains);
        case Stage::powers:
            return find_powers();
        case Stage::taper:
            return taper(trains);
        case Stage::row:
            return begin_row();
        case Stage::column:
            return try_column();
        case Stage::part:
            return judge_part();
        case Stage::sums:
            add_sums(trains);
            if (state_.next == fields_.size()) refine(trains, estimate);
            return;
        case Stage::complete:
            return;
    }
}

void WaveFit::go_to(Stage stage) noexcept {
    state_.stage = stage;
    state_.next = 0;
}

// Takes one spike, with those before it. Σ |c_i(ω)|² is the cosine transform of the times between the spikes
// of an afferent.
void WaveFit::add_lags(const SpikeTrains& trains) noexcept {
    const auto train = trains.of(state_.next);
    const std::size_t a = state_.spike;
    if (a == train.size()) {
        state_.spike = 0;
        if (++state_.next == fields_.size()) {
            go_to(Stage::powers);
            state_.next = first_power;
        }
        return;
    }
    double* const weights = weights_of(state_.next);
    weights[a] = hann(train[a] * 1e-9, window_s_);
    lags_[0] += weights[a] * weights[a];
    for (std::size_t b = 0; b < a; ++b) {
        const std::size_t steps = (train[a] - train[b] + lag_ns / 2) / lag_ns;
        lags_[std::min(steps, lags_.size() - 1)] += 2 * weights[a] * weights[b];
    }
    ++state_.spike;
}

// Takes several frequencies at once: an addition to one of their sums need not wait for those to the others.
void WaveFit::find_powers() noexcept {
    double sums[powers_at_once]{};
    std::size_t at[powers_at_once]{};
    for (const double lag : lags_)
        for (std::size_t i = 0; i < powers_at_once; ++i) {
            sums[i] += lag * cosines_[at[i]];
            at[i] += state_.next + i;
            if (at[i] >= cosines_.size()) at[i] -= cosines_.size();
        }
    for (const double sum : sums)
        if (state_.next < powers_.size()) powers_[state_.next++] = sum;
    if (state_.next < powers_.size()) return;
    find_frequencies();
    try_next_frequency();
}

void WaveFit::find_frequencies() noexcept {
    frequencies_.clear();
    for (std::size_t i = first_power + 1; i + 1 < powers_.size(); ++i) {
        if (powers_[i] < powers_[i - 1] || powers_[i] <= powers_[i + 1]) continue;
        const auto lower = std::find_if(frequencies_.begin(), frequencies_.end(),
                                        [&](std::size_t other) { return powers_[other] < powers_[i]; });
        frequencies_.insert(lower, i);
        if (frequencies_.size() > most_frequencies) frequencies_.pop_back();
    }
}

// After the last frequency, the parts of the best wave are tried.
void WaveFit::try_next_frequency() noexcept {
    if (state_.candidate == frequencies_.size()) {
        if (!(state_.best.z > bound_)) return go_to(Stage::complete);
        return try_next_part();
    }
    const auto frequency = static_cast<double>(frequencies_[state_.candidate++]);
    state_.tried = {.radians_per_s = turn * frequency / (static_cast<double>(cosines_.size()) * lag_s)};
    go_to(Stage::taper);
}

void WaveFit::taper(const SpikeTrains& trains) noexcept {
    const auto train = trains.of(state_.next);
    const double* const weights = weights_of(state_.next);
    Complex sum;
    for (std::size_t a = 0; a < train.size(); ++a) {
        const double angle = state_.tried.radians_per_s * (train[a] * 1e-9);
        sum.re += weights[a] * std::cos(angle);
        sum.im += weights[a] * std::sin(angle);
    }
    if (state_.next == 0) state_.squares = 0;
    state_.squares += sum.re * sum.re + sum.im * sum.im;
    tapered_[state_.next++] = sum;
    if (state_.next < fields_.size()) return;
    if (state_.part > 1) return go_to(Stage::part);
    if (!(state_.squares > 0)) return try_next_frequency();
    state_.row = -rows();
    go_to(Stage::row);
}

// Wave vectors are tried on a grid, row by row. In a row, exp(−i k_y y) is the same for all columns.
void WaveFit::begin_row() noexcept {
    const std::size_t n = fields_.size();
    const Complex* const turns = &row_turns_[static_cast<std::size_t>(std::abs(state_.row)) * n];
    const double sign = state_.row < 0 ? -1 : 1;
    for (std::size_t i = 0; i < n; ++i) {
        const Complex c = tapered_[i];
        const double cos = turns[i].re, sin = sign * turns[i].im;
        turned_[i] = {c.re * cos + c.im * sin, c.im * cos - c.re * sin};
    }
    state_.column = 0;
    go_to(Stage::column);
}

// Takes the wave vectors of k_x and −k_x, whose sums differ in the sign of sin k_x x only.
void WaveFit::try_column() noexcept {
    const std::size_t n = fields_.size();
    const Complex* const turns = &column_turns_[static_cast<std::size_t>(state_.column) * n];
    Complex cosines, sines;
    for (std::size_t i = 0; i < n; ++i) {
        const Complex c = turned_[i];
        cosines.re += c.re * turns[i].re;
        cosines.im += c.im * turns[i].re;
        sines.re += c.re * turns[i].im;
        sines.im += c.im * turns[i].im;
    }
    const double x_per_mm = state_.column * step_x_per_mm_, y_per_mm = state_.row * step_y_per_mm_;
    for (const double sign : {-1.0, 1.0}) {
        const double re = cosines.re + sign * sines.im, im = cosines.im - sign * sines.re;
        const double z = (re * re + im * im) / state_.squares;
        if (z > state_.best.z) state_.best = {{state_.tried.radians_per_s, sign * x_per_mm, y_per_mm}, z};
    }
    const double longest_x = std::sqrt(std::max(0.0, most_per_mm_ * most_per_mm_ - y_per_mm * y_per_mm));
    if (++state_.column <= static_cast<int>(longest_x / step_x_per_mm_)) return;
    if (++state_.row <= rows()) return go_to(Stage::row);
    try_next_frequency();
}

void WaveFit::try_next_part() noexcept {
    for (;;) {
        while (++state_.part <= 3) {
            const Wave& found = state_.best.wave;
            const double part = state_.part;
            state_.tried = {found.radians_per_s / part, found.x_per_mm / part, found.y_per_mm / part};
            if (state_.tried.radians_per_s * window_s_ >= turn) return go_to(Stage::taper);
        }
        state_.part = 1;
        if (state_.lower.z == 0) break;
        state_.best = std::exchange(state_.lower, {});
    }
    state_.refined = state_.best.wave;
    go_to(Stage::sums);
}

// A lower wave is a part of what has been found, and more of a wave than a motion of the whole skin is: what
// leaks from other frequencies of trains that are in phase is neither.
void WaveFit::judge_part() noexcept {
    const double significant = std::log(10 / false_alarm);
    constexpr double least_part = 0.25;
    const double z = coherence(state_.tried.x_per_mm, state_.tried.y_per_mm);
    if (z > std::max({state_.lower.z, significant, least_part * state_.best.z, coherence(0, 0)}))
        state_.lower = {state_.tried, z};
    try_next_part();
}

double WaveFit::coherence(double x_per_mm, double y_per_mm) const noexcept {
    double re = 0, im = 0;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
        const Complex& c = tapered_[i];
        const double phase = x_per_mm * fields_[i].x_mm + y_per_mm * fields_[i].y_mm;
        const double cos = std::cos(phase), sin = std::sin(phase);
        re += c.re * cos + c.im * sin;
        im += c.im * cos - c.re * sin;
    }
    return state_.squares > 0 ? (re * re + im * im) / state_.squares : 0;
}

// Takes one afferent.
void WaveFit::add_sums(const SpikeTrains& trains) noexcept {
    const std::size_t i = state_.next++;
    const auto train = trains.of(i);
    if (train.empty()) return;
    Sums& all = state_.sums;
    const Wave& wave = state_.refined;
    ++all.afferents;
    const double x = fields_[i].x_mm, y = fields_[i].y_mm;
    const double lag = wave.x_per_mm * x + wave.y_per_mm * y + state_.phase;
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

// A step of Newton's method, by the sums over all afferents. The first finds the phase that suits the wave
// best.
void WaveFit::refine(const SpikeTrains& trains, TextureEstimate& estimate) noexcept {
    Sums at = std::exchange(state_.sums, {});
    go_to(Stage::sums);
    if (state_.steps++ == 0) {
        state_.phase = std::atan2(at.gradient[3], at.cosines);
        return;
    }
    if (at.afferents <= unknowns || !factor(at.hessian)) return go_to(Stage::complete);
    Wave& wave = state_.refined;
    if (state_.converged || state_.steps > most_steps + 1) {
        go_to(Stage::complete);
        SmallMatrix<unknowns> covariance = covariance_of(at);
        if (wave.radians_per_s < turn * fewest_periods / window_s_) return;
        correct_for_pressure(trains, wave, covariance);
        return tell(wave, covariance, estimate);
    }
    const SmallVector<unknowns> by = solve(at.hessian, at.gradient);
    wave.radians_per_s += by[0];
    wave.x_per_mm += by[1];
    wave.y_per_mm += by[2];
    state_.phase += by[3];
    // A bound on how far the angle of a spike has changed. As convergence is quadratic, a change below the
    // root of the rounding error leaves an error below the rounding error.
    const double longest_mm = turn / least_per_mm_;
    const double change =
        std::abs(by[0]) * window_s_ / 2 + std::hypot(by[1], by[2]) * longest_mm + std::abs(by[3]);
    state_.converged = change < 1e-8;
}

// The Hessian has been factored.
SmallMatrix<WaveFit::unknowns> WaveFit::covariance_of(Sums& at) noexcept {
    const SmallMatrix<unknowns> bread = inverse(at.hessian);
    const double n = static_cast<double>(at.afferents);
    for (std::size_t a = 0; a < unknowns; ++a)
        for (std::size_t b = 0; b < a; ++b) at.scores[b][a] = at.scores[a][b];
    SmallMatrix<unknowns> covariance;
    for (std::size_t a = 0; a < unknowns; ++a)
        for (std::size_t b = 0; b < unknowns; ++b) {
            double sum = 0;
            for (std::size_t c = 0; c < unknowns; ++c)
                for (std::size_t d = 0; d < unknowns; ++d) sum += bread[a][c] * at.scores[c][d] * bread[d][b];
            covariance[a][b] = sum * n / (n - unknowns);
        }
    return covariance;
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

void WaveFit::tell(const Wave& wave, const SmallMatrix<unknowns>& covariance,
                   TextureEstimate& estimate) const noexcept {
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

std::size_t WaveFit::heap_bytes() const noexcept {
    return fields_.capacity() * sizeof(SkinField) +
           (cosines_.capacity() + weights_.capacity() + lags_.capacity() + powers_.capacity()) *
               sizeof(double) +
           frequencies_.capacity() * sizeof(std::size_t) +
           (tapered_.capacity() + turned_.capacity() + column_turns_.capacity() + row_turns_.capacity()) *
               sizeof(Complex);
}

}  // namespace afferent
