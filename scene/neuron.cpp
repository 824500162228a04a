#include "afferent/scene/neuron.hpp"

#include <algorithm>

#include "afferent/neurons/dense_population.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/patch_plan.hpp"

namespace afferent {
namespace {

// Fewer neurons than this do not fill the vectors of a sweep often enough to pay for it.
constexpr std::uint32_t worth_sweeping = 512;

// The sweep serves populations that are sampled by a clock; prediction serves everything.
std::optional<std::string> dense_refusal(const PatchPlan& patch, bool clocked) {
    if (!clocked) return "the samples come at times of their own";
    if (sample_time(1'000'000, patch.sensor.rate_hz) - scene_start != 1'000'000 * patch.scan_interval)
        return "the sampling interval is not a whole number of nanoseconds";
    const auto* lif = std::get_if<LifParameters>(&patch.neuron);
    if (!lif) return std::string("its neurons are ") + name(patch.neuron);
    return DensePopulation::refusal(*lif, patch.scan_interval);
}

}  // namespace

NeuronModel model_of(const scene::Neuron& neuron) {
    if (!neuron.fixed_point) return static_cast<const LifParameters&>(neuron);
    return FixedPointParameters{.lif = neuron,
                                .tick_us = neuron.fixed_point->tick_us,
                                .state_bits = neuron.fixed_point->state_bits,
                                .decay_bits = neuron.fixed_point->decay_bits,
                                .rounding = neuron.fixed_point->rounding};
}

void plan_form(PatchPlan& patch, scene::Form asked, bool clocked) {
    patch.scan_interval = sample_time(1, patch.sensor.rate_hz) - scene_start;
    const auto refusal = dense_refusal(patch, clocked);
    if (asked == scene::Form::dense && refusal)
        throw ParameterError("form", "SPARSE here", "DENSE: " + *refusal);
    const std::string neurons = std::to_string(patch.afferents()) + " neurons";
    const bool many = patch.afferents() >= worth_sweeping;
    const bool pays =
        !refusal && DensePopulation::pays(std::get<LifParameters>(patch.neuron), patch.scan_interval);
    const bool worth_it = many && pays;
    patch.form = asked == scene::Form::automatic && !worth_it ? scene::Form::sparse : asked;
    patch.form_reason = asked == scene::Form::sparse  ? "neuron.form is SPARSE"
                        : asked == scene::Form::dense ? "neuron.form is DENSE"
                        : refusal                     ? *refusal
                        : worth_it                    ? neurons + " on one clock"
                        : many ? "at this scan interval the neurons are too stiff for a sweep to pay"
                               : neurons + " are too few to sweep";
}

const char* describe(scene::Form form) {
    switch (form) {
        case scene::Form::sparse:
            return "neurons, by prediction";
        case scene::Form::dense:
            return "neurons, by a sweep per scan";
        case scene::Form::automatic:
            break;
    }
    return "neurons, by prediction, and by a sweep per scan where much happens";
}

}  // namespace afferent
