#include "afferent/decoders/common_change.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// A transient afferent under the contact that fires after so long a pause begins another change.
constexpr Duration pause = 100ms;
// Corner frequencies spread a sudden change over this time.
constexpr double least_change_s = 0.01;
// What a transient afferent feels is the mean of the sustained ones around it, weighted by a Gaussian of this
// standard deviation.
constexpr double around_mm = 0.6;
// The prior: the contact is lifted off, loses a part of its pressure, or rises; otherwise nothing has
// changed. A rise from pressures that have fallen unnoticed is rare.
constexpr double lifted_off = 0.1;
constexpr double falls_by_part = 0.2;
constexpr double rises_somehow = 0.5;
constexpr double rises_from_below = 0.01;
constexpr double smallest_rise = 0.005;
constexpr double largest_rise = 2;
// The probability that a transient afferent contradicts the model: it is dead, or fires by noise.
constexpr double transient_outliers = 0.05;
// The same for a sustained one.
constexpr double sustained_outliers = 0.02;
// The pressures under one contact change by the same part within this standard deviation.
constexpr double alike = 0.15;
// All q may be wrong by a common factor, with this standard deviation.
constexpr double gain_sigma = 0.1;

// A soft step from 0 to 1 where x passes the threshold: x^k/(x^k + threshold^k), k = 2^squarings.
double passes(double x, double threshold, int squarings) noexcept {
    if (!(x > 0)) return 0;
    double ratio = threshold / x;
    for (int i = 0; i < squarings; ++i) ratio *= ratio;
    return 1 / (1 + ratio);
}

}  // namespace

CommonChange::CommonChange(std::size_t addresses, std::span<const SkinField> sustained,
                           std::vector<Transient> transients)
    : transients_(std::move(transients)) {
    if (transients_.empty()) return;
    require(!sustained.empty(), "sustained", "at least one", 0);
    index_of_.assign(addresses, not_read);
    neighbours_.reserve(transients_.size());
    for (std::uint32_t i = 0; i < transients_.size(); ++i) {
        const Transient& transient = transients_[i];
        require(transient.address < addresses, "transients.address", "below the number of addresses",
                transient.address);
        require(transient.fall_n_per_mm2 > 0, "transients.fall_n_per_mm2", "> 0", transient.fall_n_per_mm2);
        require(transient.rise_n_per_mm2 > 0, "transients.rise_n_per_mm2", "> 0", transient.rise_n_per_mm2);
        require(transient.tau_m_s > 0, "transients.tau_m_s", "> 0", transient.tau_m_s);
        index_of_[transient.address] = i;
        neighbours_.push_back(neighbours_of(transient.field, sustained));
    }
    for (std::size_t k = 0; k < steps; ++k) {
        const double part = static_cast<double>(k + 1) / steps;
        change_[k] = -part;
        prior_[k] = k + 1 < steps ? falls_by_part / (steps - 1) : lifted_off;
        change_[steps + 1 + k] = smallest_rise * std::pow(largest_rise / smallest_rise, part);
        prior_[steps + 1 + k] = rises_somehow / steps;
        change_[from_below + k] = change_[steps + 1 + k];
        prior_[from_below + k] = rises_from_below / steps;
    }
    prior_[steps] = 1 - lifted_off - falls_by_part - rises_somehow - rises_from_below;
    works_.resize(transients_.size());
    spikes_.resize(transients_.size());
    held_.resize(sustained.size());
}

CommonChange::Neighbours CommonChange::neighbours_of(const SkinField& field,
                                                     std::span<const SkinField> sustained) const {
    std::vector<std::pair<double, std::uint32_t>> by_square_mm2;
    for (std::uint32_t i = 0; i < sustained.size(); ++i)
        by_square_mm2.emplace_back(
            std::pow(sustained[i].x_mm - field.x_mm, 2) + std::pow(sustained[i].y_mm - field.y_mm, 2), i);
    std::ranges::sort(by_square_mm2);
    Neighbours near;
    double sum = 0;
    for (std::size_t k = 0; k < std::min(nearest, by_square_mm2.size()); ++k) {
        const auto& [square_mm2, i] = by_square_mm2[k];
        near.index[k] = i;
        sum += near.weight[k] = std::exp(-square_mm2 / (2 * around_mm * around_mm));
    }
    if (sum > 0)
        for (double& weight : near.weight) weight /= sum;
    return near;
}

void CommonChange::restart() noexcept {
    std::ranges::fill(works_, 0);
    std::ranges::fill(spikes_, 0);
    std::ranges::fill(held_, 0.0);
    begin_ = end_ = never_fired;
}

bool CommonChange::begins(TimePoint time) const noexcept { return time - end_ > pause; }

bool CommonChange::feels(std::uint32_t index, std::span<const double> pressures) const noexcept {
    return felt_by(index, pressures) > 0;
}

void CommonChange::begin(TimePoint time, std::span<const double> pressures, bool common) noexcept {
    std::ranges::copy(pressures, held_.begin());
    std::ranges::fill(spikes_, 0);
    begin_ = common ? time : never_fired;
}

void CommonChange::hear(std::uint32_t index, TimePoint time) noexcept {
    works_[index] = true;
    ++spikes_[index];
    if (feels(index, held_)) end_ = time;
}

double CommonChange::felt_by(std::uint32_t index, std::span<const double> pressures) const noexcept {
    const Neighbours& near = neighbours_[index];
    double sum = 0;
    for (std::size_t k = 0; k < nearest; ++k) sum += near.weight[k] * pressures[near.index[k]];
    return sum;
}

// Normalises, so that the product of many likelihoods does not underflow.
template <class Likelihood>
void CommonChange::multiply(Posterior& posterior, const Likelihood& likelihood,
                            std::size_t first_changes) const noexcept {
    for (std::size_t k = 0; k < first_changes; ++k) posterior[k] *= likelihood(change_[k]);
    const double highest = *std::ranges::max_element(posterior);
    for (double& each : posterior) each /= highest;
}

void CommonChange::add(std::uint32_t index, double heard, Posterior& posterior) const noexcept {
    const Transient& transient = transients_[index];
    const double held = felt_by(index, held_);
    // An afferent that has never fired may be dead, so that its silence does not count.
    if (!(held > 0) || !works_[index]) return;
    const std::uint32_t spikes = spikes_[index];
    const double x = (seconds(end_ - begin_) + least_change_s) / transient.tau_m_s;
    // Each of several spikes needs as much as the first.
    const double needed = std::max(1U, spikes) * x / -std::expm1(-x);
    multiply(posterior, [&](double change) {
        const double q = change < 0 ? transient.fall_n_per_mm2 : transient.rise_n_per_mm2;
        const double fires = passes(std::abs(change) * held, needed * q, 2);
        return transient_outliers + (1 - 2 * transient_outliers) * (spikes > 0 ? fires : 1 - heard * fires);
    });
}

void CommonChange::add(const Sustained& told, Posterior& posterior) const noexcept {
    if (told.rises) {
        multiply(posterior, [](double change) { return change < 0 ? sustained_outliers : 1; });
    } else if (told.held > 0 && told.measured > 0) {
        multiply(posterior, [&](double change) {
            const double off = told.measured / told.held - 1 - std::min(change, 0.0);
            return change > 0 && off > 0
                       ? 1
                       : sustained_outliers +
                             (1 - sustained_outliers) * std::exp(-off * off / (2 * alike * alike));
        });
    } else if (told.held > 0) {
        multiply(
            posterior,
            [&](double change) {
                return sustained_outliers +
                       (1 - sustained_outliers) * passes(told.at_most, (1 + change) * told.held, 4);
            },
            from_below);
    }
}

CommonChange::Factor CommonChange::mean_of(const Posterior& posterior) const noexcept {
    double sum = 0, mean = 0, squares = 0;
    for (std::size_t k = 0; k < changes; ++k) {
        const double factor = 1 + std::min(change_[k], 0.0);
        sum += posterior[k];
        mean += posterior[k] * factor;
        squares += posterior[k] * factor * factor;
    }
    mean /= sum;
    return {mean, std::hypot(std::sqrt(std::max(0.0, squares / sum - mean * mean)), gain_sigma * (1 - mean))};
}

void CommonChange::resume(const Snapshot& snapshot) {
    require(snapshot.works.size() == works_.size() && snapshot.spikes.size() == spikes_.size() &&
                snapshot.held.size() == held_.size(),
            "snapshot.works", "one for each transient afferent", static_cast<double>(snapshot.works.size()));
    works_ = snapshot.works;
    spikes_ = snapshot.spikes;
    held_ = snapshot.held;
    begin_ = snapshot.begin;
    end_ = snapshot.end;
}

std::size_t CommonChange::heap_bytes() const noexcept {
    return transients_.capacity() * sizeof(Transient) + index_of_.capacity() * sizeof(std::uint32_t) +
           neighbours_.capacity() * sizeof(Neighbours) + works_.capacity() +
           spikes_.capacity() * sizeof(std::uint32_t) + held_.capacity() * sizeof(double);
}

}  // namespace afferent
