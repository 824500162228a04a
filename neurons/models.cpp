#include "afferent/neurons/models.hpp"

#include "afferent/neurons/sparse_population.hpp"

namespace afferent {

AnyNeuron smallest_model(const NeuronModel& model) {
    const auto any = [](const auto& neuron) { return AnyNeuron(neuron); };
    return std::visit([&](const auto& parameters) { return std::visit(any, smallest_neuron(parameters)); },
                      model);
}

void check(const NeuronModel& model) {
    std::visit([](const auto& parameters) { parameters.check(); }, model);
}

const char* name(const NeuronModel& model) {
    return std::visit([](const auto& parameters) { return parameters.name; }, model);
}

std::string describe(const NeuronModel& model) {
    return std::visit([](const auto& parameters) { return parameters.describe(); }, model);
}

double adaptation(const NeuronModel& model) {
    return std::visit([](const auto& parameters) { return parameters.adaptation(); }, model);
}

NeuronModel with_adaptation(const NeuronModel& model, double delta_g) {
    return std::visit(
        [&](const auto& parameters) { return NeuronModel(parameters.with_adaptation(delta_g)); }, model);
}

Milliseconds refractory(const NeuronModel& model) {
    return std::visit([](const auto& parameters) { return parameters.refractory(); }, model);
}

std::size_t bytes_per_neuron(const NeuronModel& model) {
    return visit_neuron(model, []<Neuron N>(const N&) { return SparsePopulation<N>::bytes_per_neuron; });
}

}  // namespace afferent
