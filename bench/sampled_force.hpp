// The force from samples, as well as it can be known: what the schemes without spikes are decoded by.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/estimate.hpp"
#include "bench/motion_particles.hpp"
#include "bench/sent_counts.hpp"
#include "bench/touch.hpp"

namespace afferent {

// By the force model of the decoder `filter`, without its approximations (motion_particles.hpp), and with all
// that is known of the sensors: how noisy a reading of that size is, each element's share, and hysteresis as
// the play that it is. Times do not decrease.
class SampledForce {
  public:
    explicit SampledForce(const TouchedForce& touched);

    // What all elements read: the mean of their grip forces, weighed by 1/variance.
    void read(double time_s, std::span<const std::uint16_t> counts);

    // Send-on-delta and its kin: within which range each element lies, also by what is not sent.
    void read_changes(double time_s, const SentCounts& sent);

    // Times do not decrease from call to call.
    Estimate at(double time_s) const;

  private:
    void pass(double time_s);
    void settle();
    double noise_n(double counts) const;

    const TouchedForce& touched_;
    MotionParticles belief_;
    double time_s_ = 0;
    double bounded_s_ = 0;  // when a range was last taken in
    double branch_ = 1;     // +1: the force has risen last, and the sensors read low
    double extreme_n_ = 0;
};

}  // namespace afferent
