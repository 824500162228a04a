#include "afferent/decoders/grip_estimator.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// Half the range of forces whose rates lie within the uncertainty of the rate. A difference, not a
// derivative: the curve is steep where neurons begin to fire, and nothing is known of the force below that.
double sigma_of(const ForceRateCurve& curve, double rate_hz, double sigma_hz) {
    return (curve.force_n(rate_hz + sigma_hz) - curve.force_n(rate_hz - sigma_hz)) / 2;
}

}  // namespace

GripEstimator::GripEstimator(ForceRateCurve pooled, std::uint32_t neurons) : pooled_(neurons) {
    curves_.push_back(std::move(pooled));
    require(neurons > 0, "patch", "at least one patch with neurons to read", neurons);
}

GripEstimator::GripEstimator(std::vector<ForceRateCurve> curves, std::vector<Neuron> neurons)
    : curves_(std::move(curves)), neurons_(std::move(neurons)) {
    for (const Neuron& neuron : neurons_) {
        assert(neuron.curve < curves_.size());
        total_share_ += neuron.share;
    }
    require(total_share_ > 0, "share", "> 0 in sum over the elements that the decoder reads", total_share_);
}

Estimate GripEstimator::operator()(const SpikeRate& rate) noexcept {
    const double known_s = seconds(rate.known());
    if (known_s <= 0) {
        last_.sigma_n = 0;
        for (const auto& curve : curves_)
            last_.sigma_n = std::max(last_.sigma_n, curve.points().back().force_n);
        return last_;
    }
    const double total_hz = static_cast<double>(rate.events()) / known_s;
    const double n = pooled_ ? pooled_ : static_cast<double>(neurons_.size());
    last_.rate_hz = total_hz / n;
    if (pooled_) {
        last_.force_n = curves_.front().force_n(total_hz);
        last_.sigma_n = sigma_of(curves_.front(), total_hz, std::sqrt(n / 6) / known_s);
        return last_;
    }
    double force = 0;
    double variance = 0;
    for (const Neuron& neuron : neurons_) {
        const ForceRateCurve& curve = curves_[neuron.curve];
        const double hz = rate.events_of(neuron.address) / known_s;
        const double weight = neuron.share / total_share_;
        force += weight * curve.force_n(hz);
        variance += std::pow(weight * sigma_of(curve, hz, std::sqrt(1.0 / 6) / known_s), 2);
    }
    last_.force_n = force;
    last_.sigma_n = std::sqrt(variance);
    return last_;
}

}  // namespace afferent
