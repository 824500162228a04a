// Grip force from counted spikes, with its uncertainty.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <vector>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/estimate.hpp"
#include "afferent/decoders/force_rate_curve.hpp"
#include "afferent/decoders/force_rate_curves.hpp"

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
    // By how much the rate of a regular train may come out too low.
    { counts.short_hz(double{}) } -> std::convertible_to<double>;
    // The rate that the silence of all afferents, or of one, still allows (silence.hpp); 0 where it adds
    // nothing to the count.
    { counts.allowed_hz() } -> std::convertible_to<double>;
    { counts.allowed_hz_of(address) } -> std::convertible_to<double>;
    // By how much one spike more or less changes the rate of a train, where less than half of what is counted
    // is known, as after a start or a long gap; 0 where more is.
    { counts.spike_hz() } -> std::convertible_to<double>;
};

// Inverts the neurons' force–rate curves, as the paper does. Causal. While a neuron adapts it fires faster
// than its steady curve says, and the estimate is too high.
//
// Uncertainty: the count of a regular train in a window T has a variance of 1/6 (averaged over rates, at a
// uniform phase). Neurons that are alike fire together, so n of them count n times what one does: the sum of
// their rates has a standard deviation of n sqrt(1/6)/T, and the variances of unlike neurons add. Where
// nothing is known, the last estimate stands, sigma is the largest force of the curves, and the estimate is
// doubted as `unknown`.
//
// While less than half of the window is known, one spike more or less in each train may move the estimate
// across its whole range, and clipping would hide that. Two sigma then cover both cases, and the estimate is
// doubted as `slow`.
//
// Slow. Where neurons have fired lately and their silence since is longer than what is counted, the force may
// be that at whose steady rate it would be as long. Sigma is raised so that the estimate and two sigma cover
// it.
//
// Saturated. A sensor at full scale reads the same under every larger force, so that the neurons fire at the
// rate of its full scale. A rate from which this one cannot be told, short of it by at most a count's error,
// says "at least so much":
//     pooled      The sum of the rates is that of all sensors at full scale. The estimate is at least what
//                 they read at most.
//     per neuron  The rate of the neuron itself. Such neurons count as their full scale or, if that is more,
//                 as the mean of those that can still tell. The estimate is saturated if they have three
//                 quarters of the share of those that fire: silent ones may be dead or unloaded.
// Two sigma then cover the largest force that one of them can tell.
class GripEstimator {
  public:
    struct Neuron {
        Address address;
        std::uint32_t
            curve;     // index into `curves`: from the grip force to the rate of neurons that are alike
        double share;  // of the grip force; its weight in the mean
        FullScale full_scale{};
    };

    // Pooled: the curve from the grip force to the sum of the rates of all neurons, and how many of them are
    // alike, for each kind. Throws ParameterError: neurons > 0.
    GripEstimator(ForceRateCurve pooled, const std::vector<std::uint32_t>& alike,
                  const FullScale& full_scale = {});

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
    static constexpr double enough_saturated = 0.75;

    Estimate unknown() noexcept;
    Estimate pooled(double total_hz, double window_s, double short_hz, double allowed_hz,
                    double spike_hz) noexcept;
    // The force may be up to `upper_n`, as far as silence tells.
    static void cover(Estimate& estimate, double upper_n) noexcept {
        if (!(upper_n > estimate.force_n)) return;
        estimate.doubt = Doubt::slow;
        estimate.sigma_n = std::max(estimate.sigma_n, (upper_n - estimate.force_n) / 2);
    }

    // The force may be down to `lower_n`.
    static void cover_below(Estimate& estimate, double lower_n) noexcept {
        estimate.sigma_n = std::max(estimate.sigma_n, (estimate.force_n - lower_n) / 2);
    }

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
    FullScale full_scale_;  // of all that are pooled
    Estimate last_{};
};

template <SpikeCounts C>
Estimate GripEstimator::operator()(const C& counts) noexcept {
    const double window_s = counts.window_s();
    if (!(window_s > 0)) return unknown();
    const double known_s = counts.known_s();
    const double total_hz = static_cast<double>(counts.events()) / known_s;
    if (pooled_ > 0)
        return pooled(total_hz, window_s, counts.short_hz(full_scale_.rate_hz / pooled_), counts.allowed_hz(),
                      counts.spike_hz());
    const double spike_hz = counts.spike_hz();
    double force_n = 0;
    double upper_n = 0;
    double lower_n = 0;
    double firing = 0;
    double saturated = 0;
    double variance = 0;
    double together_n = 0;
    const auto is_saturated = [&](const Neuron& neuron, double hz) {
        return neuron.full_scale.is_reached(hz, counts.short_hz(neuron.full_scale.rate_hz));
    };
    for (std::size_t i = 0; i < neurons_.size(); ++i) {
        const Neuron& neuron = neurons_[i];
        const ForceRateCurve& curve = curves_[neuron.curve];
        const double hz = counts.events_of(neuron.address) / known_s;
        const double weight = neuron.share / total_share_;
        const double neuron_n = curve.force_n(hz);
        if (hz > 0) firing += weight;
        lower_n += weight * curve.force_n(hz - spike_hz);
        if (is_saturated(neuron, hz)) {
            saturated += weight;
        } else {
            force_n += weight * neuron_n;
            upper_n += weight * std::max(curve.force_n(hz + spike_hz),
                                         curve.force_n(counts.allowed_hz_of(neuron.address)));
        }
        together_n += weight * sigma_of(curve, hz, std::sqrt(1.0 / 6) / window_s);
        if (i + 1 < neurons_.size() && neurons_[i + 1].curve == neuron.curve) continue;
        variance += together_n * together_n;
        together_n = 0;
    }
    double largest_full_scale_n = 0;
    if (saturated > 0) {
        const double others_n = saturated < 1 ? force_n / (1 - saturated) : 0;
        for (const Neuron& neuron : neurons_)
            if (is_saturated(neuron, counts.events_of(neuron.address) / known_s)) {
                const double least_n =
                    neuron.share / total_share_ * std::max(neuron.full_scale.reading_n, others_n);
                force_n += least_n;
                upper_n += least_n;
                largest_full_scale_n = std::max(largest_full_scale_n, neuron.full_scale.reading_n);
            }
    }
    last_ = {force_n, std::sqrt(variance), total_hz / static_cast<double>(neurons_.size())};
    cover(last_, upper_n);
    if (spike_hz > 0) cover_below(last_, lower_n);
    if (saturated > 0 && saturated >= enough_saturated * firing) {
        cover(last_, largest_full_scale_n);
        last_.doubt = Doubt::saturated;
    }
    return last_;
}

}  // namespace afferent
