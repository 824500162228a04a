// Grip force from counted spikes, with its uncertainty.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <vector>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/estimate.hpp"
#include "afferent/decoders/force_rate_curve.hpp"

namespace afferent {

// Spikes counted over the recent past, weighted or not.
template <class C>
concept SpikeCounts = requires(const C& counts, Address address) {
    { counts.events() } -> std::convertible_to<double>;  // sum over all afferents read
    { counts.events_of(address) } -> std::convertible_to<double>;
    // The known time, weighted alike: a count divided by it is a rate.
    { counts.known_s() } -> std::convertible_to<double>;
    // The length of the sliding window whose count of whole spikes would be as uncertain; 0 where nothing is
    // known.
    { counts.window_s() } -> std::convertible_to<double>;
};

enum class Pooling {
    pooled,      // one curve from the grip force to the sum of all rates
    per_neuron,  // each neuron's rate through its own curve; then their mean
};

// Inverts the neurons' force–rate curves, as the paper does. Causal. While a neuron adapts it fires faster
// than its steady curve says, and the estimate is too high.
//
// Uncertainty: the count of a regular train in a window T has a variance of 1/6 (averaged over rates, at a
// uniform phase). Neurons that are alike fire together, so n of them count n times what one does: the sum of
// their rates has a standard deviation of n sqrt(1/6)/T, and the variances of unlike neurons add. Where
// nothing is known, the last estimate stands and sigma is the largest force of the curves.
class GripEstimator {
  public:
    struct Neuron {
        Address address;
        std::uint32_t
            curve;     // index into `curves`: from the grip force to the rate of neurons that are alike
        double share;  // of the grip force; its weight in the mean
    };

    // Pooled: the curve from the grip force to the sum of the rates of all neurons, and how many of them are
    // alike, for each kind. Throws ParameterError: neurons > 0.
    GripEstimator(ForceRateCurve pooled, const std::vector<std::uint32_t>& alike);

    // Per neuron. Throws ParameterError: the shares have a sum > 0.
    GripEstimator(std::vector<ForceRateCurve> curves, std::vector<Neuron> neurons);

    // Computes the curves from the neurons. Throws ParameterError as they do, and as afferents.check() does.
    static GripEstimator of(const DecodedAfferents& afferents, RateKind curve, Pooling pooling);

    template <SpikeCounts C>
    Estimate operator()(const C& counts) noexcept;

    void reset() noexcept { last_ = {}; }
    // Continues after that estimate, which stands for as long as nothing is known.
    void resume(const Estimate& last) noexcept { last_ = last; }
    const Estimate& last() const noexcept { return last_; }

    // Its memory on the heap.
    std::size_t heap_bytes() const noexcept;

  private:
    Estimate unknown() noexcept;
    Estimate pooled(double total_hz, double window_s) noexcept;

    // Half the range of forces whose rates lie within the uncertainty of the rate. A difference and not a
    // derivative, because the curve is steep where neurons begin to fire and undefined below.
    static double sigma_of(const ForceRateCurve& curve, double rate_hz, double sigma_hz) noexcept {
        return (curve.force_n(rate_hz + sigma_hz) - curve.force_n(rate_hz - sigma_hz)) / 2;
    }

    std::vector<ForceRateCurve> curves_;
    std::vector<Neuron> neurons_;  // by curve; none if pooled
    double pooled_ = 0;            // neurons in the one curve; 0 if each has its own
    double counts_as_ = 0;         // of the pooled neurons: the root of the sum of the squares of `alike`
    double total_share_ = 0;
    Estimate last_{};
};

template <SpikeCounts C>
Estimate GripEstimator::operator()(const C& counts) noexcept {
    const double window_s = counts.window_s();
    if (!(window_s > 0)) return unknown();
    const double known_s = counts.known_s();
    const double total_hz = static_cast<double>(counts.events()) / known_s;
    if (pooled_ > 0) return pooled(total_hz, window_s);
    double force_n = 0;
    double variance = 0;
    double together_n = 0;
    for (std::size_t i = 0; i < neurons_.size(); ++i) {
        const Neuron& neuron = neurons_[i];
        const ForceRateCurve& curve = curves_[neuron.curve];
        const double hz = counts.events_of(neuron.address) / known_s;
        const double weight = neuron.share / total_share_;
        force_n += weight * curve.force_n(hz);
        together_n += weight * sigma_of(curve, hz, std::sqrt(1.0 / 6) / window_s);
        if (i + 1 < neurons_.size() && neurons_[i + 1].curve == neuron.curve) continue;
        variance += together_n * together_n;
        together_n = 0;
    }
    last_ = {force_n, std::sqrt(variance), total_hz / static_cast<double>(neurons_.size())};
    return last_;
}

}  // namespace afferent
