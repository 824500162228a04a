#include "afferent/neurons/rate.hpp"

#include <variant>

#include "afferent/neurons/models.hpp"
#include "afferent/neurons/simulated_rate.hpp"

namespace afferent {
namespace {

// Closed forms are overloads; every other model is simulated.
double rate_of(RateKind kind, const LifParameters& parameters, double drive_mv) {
    return lif_rate_hz(kind, parameters, drive_mv);
}
template <class Parameters>
double rate_of(RateKind kind, const Parameters& parameters, double drive_mv) {
    return std::visit([&](const auto& neuron) { return simulated_rate_hz(kind, neuron, drive_mv); },
                      smallest_neuron(parameters));
}

double rheobase_of(const LifParameters& parameters) { return parameters.rheobase_mv(); }
template <class Parameters>
double rheobase_of(const Parameters& parameters) {
    return std::visit([](const auto& neuron) { return simulated_rheobase_mv(neuron); },
                      smallest_neuron(parameters));
}

double drive_of(RateKind kind, const LifParameters& parameters, double rate_hz) {
    return lif_drive_mv(kind, parameters, rate_hz);
}
template <class Parameters>
double drive_of(RateKind kind, const Parameters& parameters, double rate_hz) {
    return std::visit(
        [&](const auto& neuron) {
            return lowest_drive_mv([&](double drive_mv) { return simulated_rate_hz(kind, neuron, drive_mv); },
                                   rate_hz);
        },
        smallest_neuron(parameters));
}

}  // namespace

double rate_hz(RateKind kind, const NeuronModel& model, double drive_mv) {
    return std::visit([&](const auto& parameters) { return rate_of(kind, parameters, drive_mv); }, model);
}

double drive_mv(RateKind kind, const NeuronModel& model, double rate_hz) {
    return std::visit([&](const auto& parameters) { return drive_of(kind, parameters, rate_hz); }, model);
}

double rheobase_mv(const NeuronModel& model) {
    return std::visit([](const auto& parameters) { return rheobase_of(parameters); }, model);
}

double highest_rate_hz(const NeuronModel& model, double drive_mv) {
    return std::visit([&](const auto& parameters) { return highest_rate_hz(parameters, drive_mv); }, model);
}

}  // namespace afferent
