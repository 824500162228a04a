#include "afferent/scene/make_shard.hpp"

#include "afferent/neurons/models.hpp"
#include "afferent/scene/dense_shard.hpp"
#include "afferent/scene/sparse_shard.hpp"

namespace afferent {
namespace {

// The neurons of some of a patch's afferents, which differ.
template <class Parameters>
struct Differing {
    std::vector<Parameters> parameters;
    std::vector<double> phases;

    Differing(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count) {
        for (std::uint32_t i = begin; i < begin + count; ++i) {
            parameters.push_back(std::get<Parameters>(patch.neuron_of(i)));
            phases.push_back(patch.variations[i].phase);
        }
    }
};

DensePopulation dense_population(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count,
                                 SpikeLimit limit) {
    if (patch.variations.empty()) return DensePopulation(patch.neuron, count, patch.scan_interval, limit);
    const Differing<LifParameters> neurons(patch, begin, count);
    return DensePopulation(neurons.parameters, patch.scan_interval, limit, neurons.phases);
}

template <Encoder E, Neuron N>
std::unique_ptr<Shard> sparse_shard(const PatchPlan& patch, FieldEncoder<E> fields, const N& neuron,
                                    std::uint32_t begin, std::uint32_t count, SpikeLimit limit) {
    const Address first = patch.first + begin;
    if (patch.variations.empty())
        return std::make_unique<SparseShard<E, N>>(std::move(fields), Alike<N>(neuron, count), first, limit,
                                                   patch.description());
    const Differing<typename N::Parameters> neurons(patch, begin, count);
    return std::make_unique<SparseShard<E, N, Individual<N>>>(
        std::move(fields), Individual<N>(neurons.parameters, neurons.phases), first, limit,
        patch.description());
}

}  // namespace

std::unique_ptr<Shard> make_shard(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count,
                                  std::uint32_t spikes_per_window) {
    const SpikeLimit limit{.spikes = spikes_per_window, .window = patch.scan_interval};
    return visit_encoder(patch.encoder, [&]<class E>(const E& encoder) -> std::unique_ptr<Shard> {
        FieldEncoder<E> fields(encoder, patch.fields, patch.first_element, begin, count);
        if (patch.dense)
            return std::make_unique<DenseShard<E>>(std::move(fields),
                                                   dense_population(patch, begin, count, limit),
                                                   patch.first + begin, patch.description());
        return visit_neuron(patch.neuron, [&]<class N>(const N& neuron) {
            return sparse_shard(patch, std::move(fields), neuron, begin, count, limit);
        });
    });
}

}  // namespace afferent
