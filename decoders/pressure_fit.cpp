#include "afferent/decoders/pressure_fit.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/decoders/small_matrix.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

using Values = PressureShape::Values;
using Matrix = SmallMatrix<PressureShape::parameters>;
constexpr std::size_t parameters = PressureShape::parameters;

// Standard deviations of the prior: a contact is as large as usual within a factor of 4 or so, lies no
// further from the mean of its readings than it is large, and is about as high as the highest of them. Edges
// are long: little speaks against them.
constexpr double size_sd = 1.5;
constexpr double form_sd = 1.5;
constexpr double peak_sd = 1;
constexpr double speed_sd_mm_per_s = 30;
constexpr double stands_mm_per_s = 1e-6;  // instead, where the velocity is to be 0
// Ages that differ by less tell of no velocity.
constexpr double least_age_sd_s = 0.01;
// Logarithms of mm² beyond which a shape is as good as a point, and as a plane.
constexpr double least_log = -9;
constexpr double most_log = 9;
// No step is longer than this in a logarithm.
constexpr double longest_step = 1.5;
constexpr int most_steps = 40;
constexpr double converged = 1e-7;

// √(1 − u²) as a difference of Gaussians in u, of variances by that of the first column, which has no more
// than 1.2 % too much force. Least squares, for a sphere and a line through a field a third as wide.
constexpr double wide_height = 9.952;
constexpr double wide_width = 0.675;
constexpr double narrow_height = 9.146;
constexpr double narrow_width = 0.55;

}  // namespace

PressureShape::PressureShape(const Values& values, double mean_variance_mm2) noexcept
    : x_(values[x]), y_(values[y]), vx_(values[vx]), vy_(values[vy]) {
    const double form = std::hypot(values[d], values[e]);
    major_ = std::exp(std::clamp(values[m] + form, least_log, most_log));
    minor_ = std::exp(std::clamp(values[m] - form, least_log, most_log));
    const double angle = std::atan2(values[e], values[d]) / 2;
    cos_ = std::cos(angle);
    sin_ = std::sin(angle);
    peak_ =
        std::exp(values[log_peak]) * std::sqrt((major_ + mean_variance_mm2) * (minor_ + mean_variance_mm2));
}

double PressureShape::read_by(const SkinField& field, double age_s) const noexcept {
    const double dx = field.x_mm - (x_ - vx_ * age_s);
    const double dy = field.y_mm - (y_ - vy_ * age_s);
    const double along = dx * cos_ + dy * sin_;
    const double across = dy * cos_ - dx * sin_;
    const auto gaussian = [&](double width) {
        const double major = width * major_ + field.variance_mm2;
        const double minor = width * minor_ + field.variance_mm2;
        return width / std::sqrt(major * minor) *
               std::exp(-(along * along / major + across * across / minor) / 2);
    };
    return peak_ * (wide_height * gaussian(wide_width) - narrow_height * gaussian(narrow_width));
}

PressureFit::PressureFit(std::vector<SkinField> fields, double usual_mm) : fields_(std::move(fields)) {
    require(!fields_.empty(), "fields", "at least one", 0);
    require(usual_mm > 0, "usual_mm", "> 0", usual_mm);
    mean_variance_mm2_ = 0;
    for (const SkinField& field : fields_) mean_variance_mm2_ += field.variance_mm2;
    mean_variance_mm2_ /= static_cast<double>(fields_.size());
    usual_log_mm2_ = std::log(usual_mm * usual_mm / 5);
    const auto weigh = [this](std::size_t parameter, double sd) { weight_[parameter] = 1 / (sd * sd); };
    weigh(PressureShape::log_peak, peak_sd);
    weigh(PressureShape::x, usual_mm);
    weigh(PressureShape::y, usual_mm);
    weigh(PressureShape::m, size_sd);
    weigh(PressureShape::d, form_sd);
    weigh(PressureShape::e, form_sd);
    weigh(PressureShape::vx, speed_sd_mm_per_s);
    weigh(PressureShape::vy, speed_sd_mm_per_s);
}

PressureFit::Values PressureFit::start(std::span<const Reading> readings, bool moves) const noexcept {
    double sum = 0, x = 0, y = 0, age = 0, peak = 0;
    const auto for_each = [&](auto&& use) {
        for (std::size_t i = 0; i < readings.size(); ++i)
            if (readings[i].lowest > 0) use(readings[i].lowest, field_of(i), readings[i].age_s);
    };
    for_each([&](double pressure, const SkinField& field, double age_s) {
        sum += pressure;
        x += pressure * field.x_mm;
        y += pressure * field.y_mm;
        age += pressure * age_s;
        peak = std::max(peak, pressure);
    });
    x /= sum;
    y /= sum;
    age /= sum;
    // The velocity is the slope of the places over the times.
    double vx = 0, vy = 0;
    if (moves) {
        double ages = sum * least_age_sd_s * least_age_sd_s, xs = 0, ys = 0;
        for_each([&](double pressure, const SkinField& field, double age_s) {
            ages += pressure * (age_s - age) * (age_s - age);
            xs += pressure * (age_s - age) * (field.x_mm - x);
            ys += pressure * (age_s - age) * (field.y_mm - y);
        });
        vx = -xs / ages;
        vy = -ys / ages;
        x += vx * age;
        y += vy * age;
    }
    double xx = 0, xy = 0, yy = 0;
    for_each([&](double pressure, const SkinField& field, double age_s) {
        const double dx = field.x_mm + vx * age_s - x;
        const double dy = field.y_mm + vy * age_s - y;
        xx += pressure / sum * dx * dx;
        xy += pressure / sum * dx * dy;
        yy += pressure / sum * dy * dy;
    });
    const double least_mm2 = std::exp(usual_log_mm2_) / 10;
    const double middle = (xx + yy) / 2;
    const double form = std::hypot((xx - yy) / 2, xy);
    const double major = std::log(std::max(middle + form - mean_variance_mm2_, least_mm2));
    const double minor = std::log(std::max(middle - form - mean_variance_mm2_, least_mm2));
    const double length = (major - minor) / 2;
    Values values{};
    values[PressureShape::log_peak] = std::log(peak);
    values[PressureShape::x] = x;
    values[PressureShape::y] = y;
    values[PressureShape::vx] = vx;
    values[PressureShape::vy] = vy;
    values[PressureShape::m] = (major + minor) / 2;
    values[PressureShape::d] = form > 0 ? length * (xx - yy) / 2 / form : 0;
    values[PressureShape::e] = form > 0 ? length * xy / form : 0;
    return values;
}

double PressureFit::misfit(std::span<const Reading> readings, const PressureShape& shape) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const double off = readings[i].off(shape.read_by(field_of(i), readings[i].age_s));
        sum += off * off;
    }
    return sum;
}

double PressureFit::cost(std::span<const Reading> readings, const Prior& prior,
                         const Values& values) const noexcept {
    double cost = misfit(readings, shape(values));
    for (std::size_t k = 0; k < parameters; ++k) {
        const double off = values[k] - prior.mean[k];
        cost += prior.weight[k] * off * off;
    }
    return cost;
}

PressureFit::Slope PressureFit::slope(std::span<const Reading> readings, const Prior& prior,
                                      const Values& values) const noexcept {
    constexpr double step = 1e-5;
    const PressureShape at = shape(values);
    const auto moved = [&](std::size_t k, double by) {
        Values other = values;
        other[k] += by;
        return shape(other);
    };
    const std::array<PressureShape, parameters> above{moved(0, step), moved(1, step), moved(2, step),
                                                      moved(3, step), moved(4, step), moved(5, step),
                                                      moved(6, step), moved(7, step)};
    Slope slope;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const SkinField& field = field_of(i);
        const double read = at.read_by(field, readings[i].age_s);
        const double off = readings[i].off(read);
        const double off_slope = readings[i].off_slope(read);
        if (off_slope == 0) continue;
        Values change;
        for (std::size_t k = 0; k < parameters; ++k)
            change[k] = (above[k].read_by(field, readings[i].age_s) - read) / step * off_slope;
        for (std::size_t k = 0; k < parameters; ++k) {
            slope.gradient[k] += change[k] * off;
            for (std::size_t j = 0; j <= k; ++j) slope.curvature[k][j] += change[k] * change[j];
        }
    }
    for (std::size_t k = 0; k < parameters; ++k) {
        slope.gradient[k] += prior.weight[k] * (prior.mean[k] - values[k]);
        slope.curvature[k][k] += prior.weight[k];
    }
    return slope;
}

// Levenberg and Marquardt.
PressureFit::Solution PressureFit::operator()(std::span<const Reading> readings, bool moves) const noexcept {
    Solution solution;
    Values& values = solution.values = start(readings, moves);
    Prior prior{values, weight_};
    prior.mean[PressureShape::m] = usual_log_mm2_;
    for (const std::size_t k : {PressureShape::d, PressureShape::e, PressureShape::vx, PressureShape::vy})
        prior.mean[k] = 0;
    if (!moves)
        for (const std::size_t k : {PressureShape::vx, PressureShape::vy})
            prior.weight[k] = 1 / (stands_mm_per_s * stands_mm_per_s);
    double least = cost(readings, prior, values);
    Slope at = slope(readings, prior, values);
    double damping = 1e-3;
    for (int steps = 0; steps < most_steps; ++steps) {
        Matrix damped = at.curvature;
        for (std::size_t k = 0; k < parameters; ++k) damped[k][k] *= 1 + damping;
        Values other = values;
        double other_cost = least;
        if (factor(damped)) {
            const Values move = solve(damped, at.gradient);
            double longest = 0;
            for (const std::size_t k : {PressureShape::m, PressureShape::d, PressureShape::e})
                longest = std::max(longest, std::abs(move[k]));
            const double part = std::min(1.0, longest_step / longest);
            for (std::size_t k = 0; k < parameters; ++k) other[k] += part * move[k];
            other_cost = cost(readings, prior, other);
        }
        if (!(other_cost < least)) {
            if (damping > 1e8) break;
            damping *= 10;
            continue;
        }
        const bool done = least - other_cost < converged * least;
        values = other;
        least = other_cost;
        at = slope(readings, prior, values);
        damping = std::max(1e-9, damping / 10);
        if (done) break;
    }
    // Curvature is positive definite by the prior, but for rounding.
    Matrix covariance = at.curvature;
    if (!factor(covariance)) return solution;
    covariance = inverse(covariance);
    if (factor(covariance)) solution.deviation = covariance;
    return solution;
}

std::size_t PressureFit::heap_bytes() const noexcept { return fields_.capacity() * sizeof(SkinField); }

}  // namespace afferent
