#include "afferent/scene/make_shard.hpp"

#include "afferent/neurons/models.hpp"
#include "afferent/scene/dense_shard.hpp"
#include "afferent/scene/sparse_shard.hpp"

namespace afferent {

std::unique_ptr<Shard> make_shard(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count,
                                  std::uint32_t spikes_per_window) {
    const Address first = patch.first + begin;
    const SpikeLimit limit{.spikes = spikes_per_window, .window = patch.scan_interval};
    return visit_encoder(patch.encoder, [&]<class E>(const E& encoder) {
        return visit_neuron(patch.neuron, [&]<class N>(const N& neuron) -> std::unique_ptr<Shard> {
            FieldEncoder<E> fields(encoder, patch.fields, patch.first_element, begin, count);
            if (patch.dense)
                return std::make_unique<DenseShard<E>>(
                    std::move(fields), std::get<LifParameters>(patch.neuron), patch.scan_interval, first,
                    limit, patch.description());
            return std::make_unique<SparseShard<E, N>>(std::move(fields), neuron, first, limit,
                                                       patch.description());
        });
    });
}

}  // namespace afferent
