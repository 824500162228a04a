// The closed list of neuron models that a scene can name, and what it asks of every one of them.
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "afferent/neurons/fixed_point.hpp"
#include "afferent/neurons/lif_models.hpp"
#include "afferent/neurons/parameters.hpp"

namespace afferent {

// To add a model, include its header above and name its parameters in NeuronModel. The parameters have the
// members that the functions below call, and beside them two functions of their own:
// smallest_neuron(parameters), the class that carries them out, in a variant; and highest_rate_hz(parameters,
// drive_mv). Every class is then tested for the laws that neurons keep.

namespace detail {

template <class... Variants>
struct Joined;
template <class... A>
struct Joined<std::variant<A...>> {
    using Type = std::variant<A...>;
};
template <class... A, class... B, class... Rest>
struct Joined<std::variant<A...>, std::variant<B...>, Rest...> : Joined<std::variant<A..., B...>, Rest...> {};

template <class Models>
struct NeuronsOf;
template <class... P>
struct NeuronsOf<std::variant<P...>> : Joined<decltype(smallest_neuron(std::declval<const P&>()))...> {};

}  // namespace detail

// Every class of neuron that a model of the list can need.
using AnyNeuron = detail::NeuronsOf<NeuronModel>::Type;

// The class of neuron that computes least for this model. Throws ParameterError.
AnyNeuron smallest_model(const NeuronModel& model);

// Calls visit(neuron) with that neuron, of its own class.
template <class Visit>
decltype(auto) visit_neuron(const NeuronModel& model, Visit&& visit) {
    return std::visit(std::forward<Visit>(visit), smallest_model(model));
}

// Throws ParameterError, naming the field.
void check(const NeuronModel& model);

// As scenes spell it: "lif", "fixed_point".
const char* name(const NeuronModel& model);
// The parameters in one line, for messages.
std::string describe(const NeuronModel& model);

// Δg; 0 if the model does not adapt.
double adaptation(const NeuronModel& model);
NeuronModel with_adaptation(const NeuronModel& model, double delta_g);
Milliseconds refractory(const NeuronModel& model);

// The memory of one neuron among many alike, by prediction (SparsePopulation).
std::size_t bytes_per_neuron(const NeuronModel& model);

}  // namespace afferent
