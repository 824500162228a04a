#include "afferent/decoders/spatial_variation.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {
namespace {

// The rates of a train in the middles of steps, less their mean. Before the first and after the last spike
// the interval is at least the one beside it.
void rates_of(std::span<const std::uint32_t> train, Duration window, std::span<double> rates) noexcept {
    const double end_s = seconds(window);
    const double step_s = end_s / static_cast<double>(rates.size());
    const auto at = [&](std::size_t i) { return train[i] * 1e-9; };
    const auto interval = [&](std::size_t after) {
        if (train.size() == 1) return end_s;
        if (after == 0) return std::max(at(0), at(1) - at(0));
        if (after < train.size()) return at(after) - at(after - 1);
        return std::max(end_s - at(after - 1), at(after - 1) - at(after - 2));
    };
    std::size_t after = 0;  // the spikes before
    double mean = 0;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        const double time_s = (static_cast<double>(i) + 0.5) * step_s;
        while (after < train.size() && at(after) <= time_s) ++after;
        // Two spikes at one tick are no closer than a millisecond.
        rates[i] = 1 / std::max(interval(after), 1e-3);
        mean += rates[i] / static_cast<double>(rates.size());
    }
    for (double& rate : rates) rate -= mean;
}

}  // namespace

SpatialVariation::SpatialVariation(const std::vector<SkinField>& fields, Duration window)
    : steps_(std::max<std::size_t>(2, static_cast<std::size_t>(window / step))),
      rates_(fields.size() * steps_),
      sums_(fields.size()) {
    for (std::uint32_t i = 0; i < fields.size(); ++i)
        for (std::uint32_t j = i + 1; j < fields.size(); ++j) {
            const double apart_mm =
                std::hypot(fields[i].x_mm - fields[j].x_mm, fields[i].y_mm - fields[j].y_mm);
            if (apart_mm >= nearest_mm && apart_mm <= farthest_mm) pairs_.push_back({i, j});
        }
}

void SpatialVariation::begin() noexcept {
    std::fill(sums_.begin(), sums_.end(), Sum());
    rated_ = compared_ = 0;
}

bool SpatialVariation::advance(const SpikeTrains& trains, WorkBudget& budget,
                               TextureEstimate& estimate) noexcept {
    while (rated_ < trains.afferents()) {
        const auto train = trains.of(rated_);
        if (!budget.take(4 * steps_ + train.size())) return false;
        if (!train.empty())
            rates_of(train, trains.window(), std::span(rates_).subspan(rated_ * steps_, steps_));
        ++rated_;
    }
    while (compared_ < pairs_.size()) {
        if (!budget.take(2 * steps_)) return false;
        add(trains, pairs_[compared_++]);
    }
    tell(estimate);
    return true;
}

void SpatialVariation::add(const SpikeTrains& trains, const Pair& pair) noexcept {
    if (trains.of(pair.one).empty() || trains.of(pair.other).empty()) return;
    const double* const one = &rates_[pair.one * steps_];
    const double* const other = &rates_[pair.other * steps_];
    double sum = 0;
    for (std::size_t t = 0; t < steps_; ++t) sum += std::abs(one[t] - other[t]);
    for (const std::uint32_t i : {pair.one, pair.other}) {
        sums_[i].hz += sum / static_cast<double>(steps_);
        ++sums_[i].pairs;
    }
}

void SpatialVariation::tell(TextureEstimate& estimate) const noexcept {
    // The mean over afferents of the mean over their neighbours.
    double count = 0, mean = 0, squares = 0;
    for (const Sum& sum : sums_) {
        if (sum.pairs == 0) continue;
        const double hz = sum.hz / static_cast<double>(sum.pairs);
        ++count;
        squares += (hz - mean) * (hz - mean) * (count - 1) / count;
        mean += (hz - mean) / count;
    }
    if (count < fewest) return;
    estimate.felt = true;
    estimate.roughness_hz = mean;
    // A mean over pairs, in each of which an afferent counts as much as the other, varies by 4/n of what the
    // means of afferents vary by (a U-statistic of degree two: Hoeffding 1948, Ann Math Stat 19:293).
    estimate.roughness_sigma_hz = std::sqrt(4 * squares / (count * (count - 1)));
}

std::size_t SpatialVariation::heap_bytes() const noexcept {
    return pairs_.capacity() * sizeof(Pair) + rates_.capacity() * sizeof(double) +
           sums_.capacity() * sizeof(Sum);
}

}  // namespace afferent
