// How often a neuron fires under a held drive, and the drive for a rate, for every model of the list.
#pragma once

#include "afferent/neurons/parameters.hpp"

namespace afferent {

// The models have been checked, and drives are finite.

// In Hz; 0 if the drive does not give two spikes.
double rate_hz(RateKind kind, const NeuronModel& model, double drive_mv);

// The inverse: the lowest drive in mV under which the neuron fires at least at that rate, which is > 0.
// +infinity where no drive does, as the refractory period is too long. A closed form where the model has one
// (the exact neurons: a state between two spikes is linear in the drive), and otherwise a search over
// simulated intervals, right within 1e-6.
double drive_mv(RateKind kind, const NeuronModel& model, double rate_hz);

// The highest drive at which the resting neuron never fires.
double rheobase_mv(const NeuronModel& model);

// An upper bound on the reciprocal of every interspike interval, whatever came before, while the drive stays
// at or below this one.
double highest_rate_hz(const NeuronModel& model, double drive_mv);

}  // namespace afferent
