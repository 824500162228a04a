#include "afferent/scene/shard_bytes.hpp"

#include <string>
#include <variant>
#include <vector>

#include "afferent/encoders/field_encoder.hpp"
#include "afferent/neurons/dense_population.hpp"
#include "afferent/neurons/sparse_population.hpp"

namespace afferent {
namespace {

// A shard's virtual table, first address, noise with the drive at rest, name for messages, and the end of its
// window.
constexpr std::size_t shard_words =
    sizeof(std::string) + 3 * sizeof(void*) + sizeof(DriveNoise) + sizeof(double);
// The levels at which a shard changes its form, its counts, and the end of the window of the second form.
constexpr std::size_t switching_words = 8 * sizeof(void*);

std::size_t swept(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count) {
    std::vector<LifParameters> parameters;
    if (patch.neurons_differ)
        for (std::uint32_t i = begin; i < begin + count; ++i)
            parameters.push_back(std::get<LifParameters>(patch.neuron_of(i)));
    const std::size_t population =
        parameters.empty() ? DensePopulation::size_of(std::get<LifParameters>(patch.neuron), count)
                           : DensePopulation::size_of(parameters, patch.scan_interval);
    // A drive for each, and room for a spike of every fourth that comes after the window.
    return population + sizeof(std::span<double>) + sizeof(std::vector<std::uint64_t>) +
           count * sizeof(double) + count / 4 * sizeof(std::uint64_t);
}

std::size_t neuron_bytes(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count) {
    if (patch.form == scene::Form::dense) return swept(patch, begin, count);
    const std::size_t sparse = visit_neuron(patch.neuron, [&]<class N>(const N&) {
        return patch.neurons_differ ? SparsePopulation<N, Individual<N>>::size_of(count)
                                    : SparsePopulation<N>::size_of(count);
    });
    if (patch.form == scene::Form::sparse) return sparse;
    return sparse + swept(patch, begin, count) + switching_words;
}

}  // namespace

std::size_t shard_bytes(const PatchPlan& patch, std::uint32_t begin, std::uint32_t count) {
    return shard_words + neuron_bytes(patch, begin, count) +
           visit_encoder(patch.encoder, [&]<class E>(const E&) {
               return sizeof(FieldEncoder<E>) + FieldEncoder<E>::size_of(patch.fields, begin, count);
           });
}

}  // namespace afferent
