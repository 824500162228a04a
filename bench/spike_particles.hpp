// The judge of the decoder `filter`: the same force model and the same spikes, by particles.
#pragma once

#include <vector>

#include "bench/motion_particles.hpp"
#include "bench/touch.hpp"

namespace afferent {

// Every membrane is a variable of each particle's Gaussian, as it is linear in the forces that the sensors
// have sampled. So a spike is the exact measurement that its gap to threshold was 0 within the tick, weighed
// by the speed at which it got there; that an afferent has not fired by the end of a scan truncates its gap;
// and what afferents know together, because they feel the same force, is not counted twice. It is slow, and
// is told what no decoder is: when the sensors sample, and how noisy each reading is.
//
// It takes the force as the sensors read it, without hysteresis.
class SpikeParticles {
  public:
    // The neurons are adapting membranes (lif), each on an element of its own.
    SpikeParticles(const TouchedForce& touched, Duration tick, const MotionParticles::Options& options);

    // All scans that end by `until` are over, and these are the events of the time in which they lie.
    void observe(TimePoint until, std::span<const Event> events);
    // `now` is not before the last scan that is over.
    Estimate at(TimePoint now) const;

  private:
    struct Membrane {
        Address address;
        LifParameters neuron;
        double drive_mv_per_n, bias_mv;
        double share;
        TimePoint time = scene_start;  // of its gap and its g
        TimePoint rises = scene_start;
        double g = 0;
    };
    void advance(std::size_t index, TimePoint to);
    void spike(std::size_t index, TimePoint stamp);

    const TouchedForce& touched_;
    Duration tick_;
    std::vector<Membrane> membranes_;
    MotionParticles force_;
    double threshold_n_;
    TimePoint scan_ = scene_start;  // the force of this time drives the membranes
};

// The estimates of a force step by step, from packets like those of `follow`.
std::vector<Estimate> follow_by_particles(const TouchedForce& touched, Duration tick, Duration deadline,
                                          const MotionParticles::Options& options);

}  // namespace afferent
