// The exact neurons that LifParameters can need: with or without adaptation and refractory period.
#pragma once

#include <optional>
#include <variant>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/lif.hpp"
#include "afferent/neurons/parameters.hpp"
#include "afferent/neurons/propagator.hpp"
#include "afferent/neurons/refractory.hpp"

namespace afferent {

// The neuron that computes least. Throws ParameterError.
std::variant<Lif, Refractory<Lif>, AdaptingLif, Refractory<AdaptingLif>> smallest_neuron(
    const LifParameters& parameters);

// Closed forms of what neurons/rate.hpp declares for every model. The parameters have been checked.
double lif_rate_hz(RateKind kind, const LifParameters& parameters, double drive_mv);
double lif_drive_mv(RateKind kind, const LifParameters& parameters, double rate_hz);
// lif_drive_mv() in two steps, of which the first takes nearly all of the time and serves every neuron that
// differs in its voltages alone: the flow from one spike to the next, and the drive under which it ends at
// the threshold. Nothing, and +infinity, where the refractory period is too long for the rate.
std::optional<Propagator> lif_flow(RateKind kind, const LifParameters& parameters, double rate_hz);
double lif_drive_mv(const LifParameters& parameters, const std::optional<Propagator>& flow);
// Whether they have the same flows.
bool flow_alike(const LifParameters& one, const LifParameters& other) noexcept;
double highest_rate_hz(const LifParameters& parameters, double drive_mv);

}  // namespace afferent
