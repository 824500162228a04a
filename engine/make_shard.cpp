#include "afferent/engine/make_shard.hpp"

#include "afferent/engine/delayed_shard.hpp"
#include "afferent/engine/encoded_shard.hpp"
#include "afferent/engine/predicted_neurons.hpp"
#include "afferent/engine/swept_neurons.hpp"
#include "afferent/engine/switching_neurons.hpp"
#include "afferent/neurons/models.hpp"

namespace afferent {
namespace {

// Some of a patch's afferents.
struct PartOfPatch {
    const PatchPlan& patch;
    std::uint32_t begin;
    std::uint32_t count;
    SpikeLimit limit;
};

Phases phases_of(const PartOfPatch& part) {
    if (!part.patch.phases) return {};
    return [phases = part.patch.phases, begin = part.begin](std::uint32_t i) { return phases(begin + i); };
}

template <class Parameters>
std::vector<Parameters> parameters_of(const PartOfPatch& part) {
    std::vector<Parameters> parameters;
    for (std::uint32_t i = part.begin; i < part.begin + part.count; ++i)
        parameters.push_back(std::get<Parameters>(part.patch.neuron_of(i)));
    return parameters;
}

template <Neuron N>
PredictedNeurons<N> predicted_alike(const PartOfPatch& part, const N& neuron) {
    return {Alike<N>(neuron, phases_of(part)), part.count, part.limit};
}

template <Neuron N>
PredictedNeurons<N, Individual<N>> predicted_individual(const PartOfPatch& part) {
    return {Individual<N>(parameters_of<typename N::Parameters>(part), phases_of(part)), part.count,
            part.limit};
}

SweptNeurons swept(const PartOfPatch& part, std::shared_ptr<DenseScratch> scratch) {
    const PatchPlan& patch = part.patch;
    if (!patch.neurons_differ)
        return SweptNeurons(DensePopulation(patch.neuron, part.count, patch.scan_interval, part.limit,
                                            phases_of(part), std::move(scratch)));
    return SweptNeurons(DensePopulation(parameters_of<LifParameters>(part), patch.scan_interval, part.limit,
                                        phases_of(part), std::move(scratch)));
}

template <Encoder E, class Neurons>
std::unique_ptr<Shard> shard(FieldEncoder<E> fields, const PartOfPatch& part, Neurons neurons) {
    return std::make_unique<EncodedShard<E, Neurons>>(std::move(fields), std::move(neurons),
                                                      part.patch.first + part.begin, part.patch.noise,
                                                      part.patch.description());
}

// Where the plan leaves the form to the shard, if the neuron has both.
template <Encoder E, Neuron N, class Elements>
std::unique_ptr<Shard> with_form(FieldEncoder<E> fields, const PartOfPatch& part,
                                 PredictedNeurons<N, Elements> predicted,
                                 const std::shared_ptr<DenseScratch>& scratch) {
    if constexpr (std::is_same_v<typename N::Parameters, LifParameters>)
        if (part.patch.form == scene::Form::automatic)
            return shard(std::move(fields), part,
                         SwitchingNeurons<N, Elements>(std::move(predicted), swept(part, scratch)));
    return shard(std::move(fields), part, std::move(predicted));
}

std::unique_ptr<Shard> shard_of(const PartOfPatch& part, const std::shared_ptr<DenseScratch>& scratch) {
    const PatchPlan& patch = part.patch;
    return visit_encoder(patch.encoder, [&]<class E>(const E& encoder) -> std::unique_ptr<Shard> {
        FieldEncoder<E> fields(encoder, patch.fields, patch.first_element, part.begin, part.count);
        if (patch.form == scene::Form::dense) return shard(std::move(fields), part, swept(part, scratch));
        return visit_neuron(patch.neuron, [&]<class N>(const N& neuron) {
            return patch.neurons_differ
                       ? with_form(std::move(fields), part, predicted_individual<N>(part), scratch)
                       : with_form(std::move(fields), part, predicted_alike(part, neuron), scratch);
        });
    });
}

}  // namespace

std::unique_ptr<Shard> make_shard(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count,
                                  std::uint32_t spikes_per_window,
                                  const std::shared_ptr<DenseScratch>& scratch) {
    const PartOfPatch part{patch, begin, count, {.spikes = spikes_per_window, .window = patch.scan_interval}};
    std::unique_ptr<Shard> made = shard_of(part, scratch);
    if (patch.conduction == Duration::zero()) return made;
    return std::make_unique<DelayedShard>(std::move(made), patch.conduction);
}

}  // namespace afferent
