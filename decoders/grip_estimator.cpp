#include "afferent/decoders/grip_estimator.hpp"

#include <algorithm>
#include <cassert>
#include <optional>
#include <tuple>

#include "afferent/decoders/force_rate_curves.hpp"
#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

GripEstimator::GripEstimator(ForceRateCurve pooled, const std::vector<std::uint32_t>& alike,
                             const FullScale& full_scale)
    : full_scale_(full_scale) {
    curves_.push_back(std::move(pooled));
    double squares = 0;
    for (const double neurons : alike) {
        pooled_ += neurons;
        squares += neurons * neurons;
    }
    counts_as_ = std::sqrt(squares);
    require(pooled_ > 0, "patch", "at least one patch with neurons to read", pooled_);
}

GripEstimator::GripEstimator(std::vector<ForceRateCurve> curves, std::vector<Neuron> neurons)
    : curves_(std::move(curves)), neurons_(std::move(neurons)) {
    std::sort(neurons_.begin(), neurons_.end(), [](const Neuron& one, const Neuron& other) {
        return std::tie(one.curve, one.address) < std::tie(other.curve, other.address);
    });
    for (const Neuron& neuron : neurons_) {
        assert(neuron.curve < curves_.size());
        total_share_ += neuron.share;
    }
    require(total_share_ > 0, "share", "> 0 in sum over the elements that the decoder reads", total_share_);
}

GripEstimator GripEstimator::of(const DecodedAfferents& afferents, RateKind kind, Pooling pooling) {
    afferents.check();
    if (pooling == Pooling::pooled) {
        std::vector<std::uint32_t> alike(afferents.groups.size(), 0);
        for (const auto& afferent : afferents.afferents) ++alike[afferent.group];
        return {pooled_curve(afferents, kind), alike, full_scale_of(afferents)};
    }
    std::vector<ForceRateCurve> curves;
    std::vector<FullScale> full_scales;  // by curve
    std::vector<Neuron> neurons;
    std::vector<std::optional<std::uint32_t>> curve_of(afferents.groups.size());
    for (const auto& [address, group, share, patch] : afferents.afferents) {
        if (share == 0) continue;  // feels nothing
        if (!curve_of[group]) {
            curve_of[group] = static_cast<std::uint32_t>(curves.size());
            const DecodedAfferents::Group& of = afferents.groups[group];
            full_scales.push_back({});
            if (std::isfinite(of.full_scale_n))
                full_scales.back() = {
                    of.rate_hz(RateKind::steady, full_scale_fraction(afferents) * of.full_scale_n),
                    of.full_scale_n, 1};
            curves.push_back(group_curve(afferents.groups[group], kind, afferents.largest_grip_n));
        }
        neurons.push_back({address, *curve_of[group], share, full_scales[*curve_of[group]]});
    }
    return {std::move(curves), std::move(neurons)};
}

Estimate GripEstimator::unknown() noexcept {
    last_.sigma_n = 0;
    for (const auto& curve : curves_) last_.sigma_n = std::max(last_.sigma_n, curve.largest_n());
    last_.doubt = std::max(last_.doubt, Doubt::unknown);
    return last_;
}

Estimate GripEstimator::pooled(double total_hz, double window_s, double short_hz, double allowed_hz,
                               double spike_hz) noexcept {
    const ForceRateCurve& curve = curves_.front();
    const double sigma_hz = counts_as_ * std::sqrt(1.0 / 6) / window_s;
    last_ = {curve.force_n(total_hz), sigma_of(curve, total_hz, sigma_hz), total_hz / pooled_};
    if (allowed_hz > 0) cover(last_, curve.force_n(pooled_ * allowed_hz));
    if (spike_hz > 0) cover(last_, curve.force_n(total_hz + pooled_ * spike_hz));
    if (full_scale_.is_reached(total_hz, short_hz)) {
        last_.force_n = std::max(last_.force_n, full_scale_.reading_n);
        cover(last_, curve.largest_n());
        last_.doubt = Doubt::saturated;
    }
    if (spike_hz > 0) cover_below(last_, curve.force_n(total_hz - pooled_ * spike_hz));
    return last_;
}

std::size_t GripEstimator::heap_bytes() const noexcept {
    std::size_t bytes = curves_.capacity() * sizeof(ForceRateCurve) + neurons_.capacity() * sizeof(Neuron);
    for (const auto& curve : curves_) bytes += curve.points().capacity() * sizeof(ForceRateCurve::Point);
    return bytes;
}

}  // namespace afferent
