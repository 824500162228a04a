// Grip force from the spike rate, with its uncertainty.
#pragma once

#include <vector>

#include "afferent/decoders/force_rate_curve.hpp"
#include "afferent/decoders/spike_rate.hpp"

namespace afferent {

struct Estimate {
    double force_n;  // grip force
    double sigma_n;  // one standard deviation of what counting whole spikes leaves open, and of what is not
                     // known
    double rate_hz;  // mean over the neurons read
};

// The paper's estimate: the rate in a sliding window through the tuned force–rate curve. Causal; during
// adaptation the rate is above the steady one, and so is the estimate.
//
// Uncertainty: a neuron that fires regularly is counted to a variance of 1/6 on average over its phase, so n
// neurons over the known time T give the sum of their rates to sqrt(n/6)/T. Where nothing is known, the last
// estimate stands and sigma is the whole range.
class GripEstimator {
  public:
    // One read neuron and the curve from the grip force to its rate.
    struct Neuron {
        Address address;
        std::uint32_t curve;  // of `curves`
        double share;         // of the grip force; weight among the neurons where each is inverted by itself
    };

    // One curve from the grip force to the sum of the rates of all that is counted: that many neurons.
    GripEstimator(ForceRateCurve pooled, std::uint32_t neurons);

    // Each neuron through its own curve; the grip force is their mean, weighted by share.
    GripEstimator(std::vector<ForceRateCurve> curves, std::vector<Neuron> neurons);

    Estimate operator()(const SpikeRate& rate) noexcept;

    void reset() noexcept { last_ = {}; }
    // Goes on after that estimate, which stands for as long as nothing is known.
    void resume(const Estimate& last) noexcept { last_ = last; }

  private:
    std::vector<ForceRateCurve> curves_;
    std::vector<Neuron> neurons_;
    std::uint32_t pooled_ = 0;  // neurons in one curve; 0: each has its own
    double total_share_ = 0;
    Estimate last_{};
};

}  // namespace afferent
