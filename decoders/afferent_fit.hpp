// What an afferent makes of the force on it, from its spikes beside a record of that force.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "afferent/neurons/models.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// A force over time: on straight lines between its points, and held before the first and after the last.
struct ForcePoint {
    double time_s;
    double force_n;
};
using ForceTrace = std::vector<ForcePoint>;
double force_n_at(const ForceTrace& trace, double time_s) noexcept;

// The mean drive over one interspike interval, which follows exactly from its two spikes and the adaptation,
// and the mean force over it with the same weights, nearly all of which lie on the last tau_m
// (neurons/propagator.hpp).
struct DriveSample {
    double force_n;
    double drive_mv;
};

// A sample for each interspike interval of one afferent, whose `spikes` are all that it fired from rest on,
// in the order of time. The sensor holds each of its samples, so the mean force lags by `delay`. There is at
// least one point of force. A neuron on a chip is taken for the one that it approximates.
std::vector<DriveSample> drive_samples(const NeuronModel& neuron, std::span<const TimePoint> spikes,
                                       const ForceTrace& force, Duration delay);

//     drive_mv = gain_mv_per_n · force_n + bias_mv
struct DriveFit {
    double gain_mv_per_n;
    double bias_mv;
    double residual_mv;  // root mean square
    std::size_t samples;
};

// By least squares. Nothing where there are fewer than three samples, or all have the same force.
std::optional<DriveFit> fit_drive(std::span<const DriveSample> samples) noexcept;

}  // namespace afferent
