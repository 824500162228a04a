// Makes a neuron meet a rate at an input.
#pragma once

#include <optional>

#include "afferent/neurons/models.hpp"
#include "afferent/neurons/parameters.hpp"

namespace afferent {

// "100 Hz at 20 N" alone does not determine a neuron: it must also be known which rate is meant and where it
// begins to fire. The input is what the encoder multiplies by its gain: a force in N, or its rate of change
// in N/s.
struct TuningTarget {
    RateKind rate = RateKind::steady;
    double rate_hz = 100;
    double input = 20;
    double begin_input = 0.3;
    // If given, delta_g is solved as well, so that the other kind of rate has this value at the same input.
    std::optional<double> other_rate_hz = std::nullopt;

    // Throws ParameterError: rate_hz > 0, begin_input >= 0, input > begin_input, other_rate_hz > 0.
    void check() const;
};

struct Tuned {
    double gain;  // mV per unit of input
    double bias_mv;
    double delta_g;      // the neuron's own where it was not solved
    double residual_hz;  // the tuned neuron's rate at the target's input, minus the target
};

// Solves gain and bias so that the drive is the rheobase at begin_input and gives the rate at input; where
// asked, delta_g as well. Throws ParameterError with the reason if no such neuron exists: a rate that the
// refractory period does not allow, an onset rate below the steady one.
Tuned tune(const NeuronModel& model, const TuningTarget& target);

}  // namespace afferent
