#include "afferent/decoders/edge_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "afferent/decoders/small_matrix.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

constexpr int plane_rounds = 30;
// Tukey's biweight is 0 from so many standard deviations on; with this many it is 95 % as good as least
// squares where nothing is wrong.
constexpr double far_off = 4.685;
// From the median of absolute values to a standard deviation.
constexpr double of_median = 1.4826;
constexpr double slides_below = 0.5;
// And its slowness is so many standard deviations long. A plane through the few afferents of an edge that is
// pressed on reaches four or so by chance.
constexpr double sure_slide = 10;
// Times are not better known than this.
constexpr double least_spread_s = 1e-5;

// A latency says its drive within this part; and a first spike that has not come, that there is less than
// this part of the hardest.
constexpr double drive_part = 0.25;
constexpr double none_part = 0.1;

constexpr double degrees = 180 / std::numbers::pi;

double within(double angle_deg, double turn_deg) {
    const double angle = std::fmod(angle_deg, turn_deg);
    return angle < 0 ? std::fmod(angle + turn_deg, turn_deg) : angle;
}

std::vector<SkinField> fields_of(const std::vector<EdgeFit::Afferent>& afferents) {
    std::vector<SkinField> fields;
    for (const EdgeFit::Afferent& afferent : afferents) fields.push_back(afferent.field);
    return fields;
}

// An edge that is long: as long as the skin is wide.
double usual_mm(const std::vector<EdgeFit::Afferent>& afferents) {
    const auto extent_mm = [&](double SkinField::*coordinate) {
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const EdgeFit::Afferent& afferent : afferents) {
            least = std::min(least, afferent.field.*coordinate);
            most = std::max(most, afferent.field.*coordinate);
        }
        return most - least;
    };
    return std::max(1e-3, std::min(extent_mm(&SkinField::x_mm), extent_mm(&SkinField::y_mm)) / 4);
}

}  // namespace

EdgeFit::EdgeFit(const std::vector<Afferent>& afferents)
    : fit_(fields_of(afferents), usual_mm(afferents)),
      off_(afferents.size()),
      sorted_(afferents.size()),
      readings_(afferents.size()) {
    require(afferents.size() >= fewest, "afferents", "at least 8", static_cast<double>(afferents.size()));
    for (const Afferent& afferent : afferents) {
        require(afferent.threshold > 0, "threshold", "> 0", afferent.threshold);
        thresholds_.push_back(afferent.threshold);
        logs_.push_back(std::log(afferent.threshold));
    }
    const auto [least, most] = std::minmax_element(logs_.begin(), logs_.end());
    const double middle = (*least + *most) / 2, half = (*most - *least) / 2;
    for (double& each : logs_) each = half > 0 ? (each - middle) / half : 0;
}

// The standard deviation of the first `count` residuals in off_, by the median of their absolute values.
double EdgeFit::spread(std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) sorted_[i] = std::abs(off_[i]);
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.begin() + static_cast<std::ptrdiff_t>(count));
    return std::max(least_spread_s, of_median * *middle);
}

SmallVector<EdgeFit::unknowns> EdgeFit::row(const First& first) const noexcept {
    const SkinField& field = fit_.fields()[first.afferent];
    const double log = logs_[first.afferent];
    return {1, field.x_mm, field.y_mm, log, log * log};
}

EdgeFit::Plane EdgeFit::plane(std::span<const First> firsts) noexcept {
    const std::size_t count = firsts.size();
    std::fill_n(off_.begin(), count, 0.0);
    Plane plane;
    plane.spread_s = 1;
    const auto weight_of = [&](std::size_t i) {
        const double far = off_[i] / (far_off * plane.spread_s);
        return std::abs(far) < 1 ? std::pow(1 - far * far, 2) : 0;
    };
    SmallMatrix<unknowns> normal;
    for (int round = 0; round < plane_rounds; ++round) {
        normal = {};
        SmallVector<unknowns> right{};
        double weights = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const double weight = weight_of(i);
            const auto at = row(firsts[i]);
            for (std::size_t k = 0; k < unknowns; ++k) {
                right[k] += weight * at[k] * firsts[i].time_s;
                for (std::size_t j = 0; j <= k; ++j) normal[k][j] += weight * at[k] * at[j];
            }
            weights += weight;
        }
        // Thresholds that are all the same leave the polynomial open, and it is then 0.
        for (std::size_t k = 3; k < unknowns; ++k) normal[k][k] += 1e-6 * static_cast<double>(count);
        if (weights <= unknowns || !factor(normal)) return plane;
        const auto found = solve(normal, right);
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = row(firsts[i]);
            off_[i] = firsts[i].time_s;
            for (std::size_t k = 0; k < unknowns; ++k) off_[i] -= found[k] * at[k];
        }
        plane.x_s_per_mm = found[1];
        plane.y_s_per_mm = found[2];
        plane.spread_s = spread(count);
    }
    // Those at the outline, whose fields are cut, are off by more and have more of a say: each counts by what
    // itself is off, as if it had had no part in the fit (MacKinnon and White 1985, HC3).
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = row(firsts[i]);
        const auto moves = solve(normal, at);
        double leverage = 0;
        for (std::size_t k = 0; k < unknowns; ++k) leverage += at[k] * moves[k];
        const double weight = weight_of(i);
        const double off =
            weight * std::max(std::abs(off_[i]), least_spread_s) / std::max(0.1, 1 - weight * leverage);
        plane.xx += off * off * moves[1] * moves[1];
        plane.xy += off * off * moves[1] * moves[2];
        plane.yy += off * off * moves[2] * moves[2];
    }
    plane.found = true;
    return plane;
}

EdgeFit::Edge EdgeFit::slid(const Plane& plane) const noexcept {
    const double x = plane.x_s_per_mm;
    const double y = plane.y_s_per_mm;
    const double square = x * x + y * y;
    const double along = (x * x * plane.xx + 2 * x * y * plane.xy + y * y * plane.yy) / square;
    const double across = (y * y * plane.xx - 2 * x * y * plane.xy + x * x * plane.yy) / square;
    const double direction_deg = std::atan2(y, x) * degrees;
    const double speed = 1 / std::sqrt(square);
    return {.slides = true,
            .orientation_deg = within(direction_deg + 90, 180),
            .sigma_deg = std::min(unknown_deg, std::sqrt(across / square) * degrees),
            .direction_deg = within(direction_deg, 360),
            .speed_mm_per_s = speed,
            .speed_sigma_mm_per_s = speed * std::sqrt(along / square)};
}

EdgeFit::Edge EdgeFit::pressed(std::span<const First> firsts) noexcept {
    for (std::size_t i = 0; i < firsts.size(); ++i) sorted_[i] = firsts[i].time_s;
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(firsts.size() / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.begin() + static_cast<std::ptrdiff_t>(firsts.size()));
    // The touch began before its first spike.
    const double before_s = std::max(*middle / 4, 1e-3);
    std::fill(readings_.begin(), readings_.end(), PressureFit::Reading{});
    double hardest = 0;
    for (const First& first : firsts) {
        const double drive = thresholds_[first.afferent] / (first.time_s + before_s);
        readings_[first.afferent].lowest = readings_[first.afferent].highest = drive;
        hardest = std::max(hardest, drive);
    }
    for (PressureFit::Reading& reading : readings_)
        reading.below = reading.above = std::hypot(drive_part * reading.lowest, none_part * hardest);
    const PressureFit::Solution solution = fit_(readings_);
    const auto orientation = [](const PressureFit::Values& values) {
        return std::atan2(values[PressureShape::e], values[PressureShape::d]) / 2;
    };
    const double angle = orientation(solution.values);
    const PressureShape shape = fit_.shape(solution.values);
    double misfit = 0;
    for (const First& first : firsts)
        misfit += std::pow(readings_[first.afferent].off(shape.read_by(fit_.fields()[first.afferent])), 2);
    double variance = 0;
    const double d = solution.values[PressureShape::d];
    const double e = solution.values[PressureShape::e];
    for (std::size_t k = 0; k < PressureShape::parameters; ++k) {
        const double turn =
            d * solution.deviation[PressureShape::e][k] - e * solution.deviation[PressureShape::d][k];
        variance += std::pow(turn / (2 * (d * d + e * e)), 2);
    }
    variance *= std::max(1.0, misfit / static_cast<double>(firsts.size()));
    const double sigma_deg = std::sqrt(variance) * degrees;
    return {.slides = false,
            .orientation_deg = within(angle * degrees, 180),
            .sigma_deg = sigma_deg < unknown_deg ? sigma_deg : unknown_deg};
}

EdgeFit::Edge EdgeFit::operator()(std::span<const First> firsts) noexcept {
    const Plane found = plane(firsts);
    double mean_s = 0;
    for (const First& first : firsts) mean_s += first.time_s / static_cast<double>(firsts.size());
    for (std::size_t i = 0; i < firsts.size(); ++i) off_[i] = firsts[i].time_s - mean_s;
    const double square = found.x_s_per_mm * found.x_s_per_mm + found.y_s_per_mm * found.y_s_per_mm;
    if (found.found && found.spread_s < slides_below * spread(firsts.size()) &&
        square > sure_slide * sure_slide * (found.xx + found.yy))
        return slid(found);
    return pressed(firsts);
}

std::size_t EdgeFit::heap_bytes() const noexcept {
    return fit_.heap_bytes() +
           (thresholds_.capacity() + logs_.capacity() + off_.capacity() + sorted_.capacity()) *
               sizeof(double) +
           readings_.capacity() * sizeof(PressureFit::Reading);
}

}  // namespace afferent
