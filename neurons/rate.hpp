// How often a neuron fires under a held drive, and the drive for a rate.
#pragma once

#include "afferent/neurons/parameters.hpp"

namespace afferent {

enum class RateKind {
    steady,  // after adaptation, under a drive held for good
    onset,   // the reciprocal of the first interspike interval after a step from rest
};

// In Hz; 0 if the drive gives no two spikes. The drive is finite, the parameters have been checked.
double rate_hz(RateKind kind, const NeuronParameters& parameters, double drive_mv);

// The inverse: the drive in mV under which the neuron fires at that rate, which is > 0. A state between two
// spikes is linear in the drive, so this is a formula and no search. +infinity where the refractory period is
// too long for it.
double drive_mv(RateKind kind, const NeuronParameters& parameters, double rate_hz);

}  // namespace afferent
