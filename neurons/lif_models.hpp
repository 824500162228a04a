// The exact neurons that LifParameters can need: with or without adaptation and refractory period.
#pragma once

#include <variant>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/lif.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/neurons/refractory.hpp"

namespace afferent {

// The neuron that computes least. Throws ParameterError.
std::variant<Lif, Refractory<Lif>, AdaptingLif, Refractory<AdaptingLif>> smallest_neuron(
    const LifParameters& parameters);

// Closed forms of what neurons/rate.hpp declares for every model. The parameters have been checked.
double lif_rate_hz(RateKind kind, const LifParameters& parameters, double drive_mv);
double lif_drive_mv(RateKind kind, const LifParameters& parameters, double rate_hz);
double highest_rate_hz(const LifParameters& parameters, double drive_mv);

}  // namespace afferent
