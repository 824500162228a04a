// The closed list of neuron models, and which of them a set of parameters needs.
#pragma once

#include <variant>

#include "afferent/neurons/adapting_lif.hpp"
#include "afferent/neurons/lif.hpp"
#include "afferent/neurons/refractory.hpp"

namespace afferent {

// To add a model, add its header and its name here; the laws that every neuron keeps are then tested for it.
using NeuronModel = std::variant<Lif, Refractory<Lif>, AdaptingLif, Refractory<AdaptingLif>>;

// The smallest model that has these parameters. Throws ParameterError.
NeuronModel smallest_model(const NeuronParameters& parameters);

}  // namespace afferent
