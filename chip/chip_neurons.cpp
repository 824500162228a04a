#include "afferent/chip/chip_neurons.hpp"

#include <algorithm>
#include <bit>
#include <string>
#include <variant>

#include "afferent/scene/scene_error.hpp"

namespace afferent {
namespace {

constexpr Address most_neurons = 65536;

FixedPointLif chip_neuron(const NeuronModel& model, const PatchPlan& patch, const std::string& file) {
    if (patch.conduction > Duration::zero())
        throw SceneError({file + ": patch \"" + patch.name +
                          "\": a chip's events leave as its neurons fire: give it no nerve"});
    if (const auto* parameters = std::get_if<FixedPointParameters>(&model)) return FixedPointLif(*parameters);
    throw SceneError({file + ": patch \"" + patch.name +
                      "\": a chip's neurons are integers: give it neuron { fixed_point {} }"});
}

std::uint32_t signed_bits(std::int64_t lowest, std::int64_t highest) {
    const auto magnitude = static_cast<std::uint64_t>(std::max(highest, -(lowest + 1)));
    return static_cast<std::uint32_t>(std::bit_width(magnitude)) + 1;
}

std::uint32_t unsigned_bits(std::uint64_t highest) {
    return static_cast<std::uint32_t>(std::bit_width(highest));
}

// How wide the largest product is, with the half that is added to it before it is shifted.
std::uint32_t product_bits(const FixedPointLif::Codes& c) {
    const auto with_half = [](std::int64_t product, std::uint32_t shift) {
        return product + (std::int64_t{1} << std::max(shift, 1U) >> 1);
    };
    const std::int64_t u = std::max(c.highest, -c.lowest);
    const std::int64_t input = std::int64_t{1} << c.input_bits >> 1;
    const std::int64_t most =
        std::max({with_half(c.g_most * c.g_decay, c.decay_bits),
                  with_half(c.g_most * c.conductance, c.conductance_bits), with_half(u * c.one, c.decay_bits),
                  with_half(u * c.v_decay + input * (c.one - c.v_decay), c.decay_bits)});
    return signed_bits(-most, most);
}

}  // namespace

const FixedPointLif& ChipNeurons::neuron(Address address) const noexcept {
    const auto after = std::ranges::upper_bound(groups, address, {}, &Group::begin);
    return std::prev(after)->neuron;
}

bool ChipNeurons::begins_at_rest() const noexcept {
    for (Address i = 0; i < count(); ++i)
        if (start[i].u != neuron(i).codes().reset) return false;
    return true;
}

ChipNeurons chip_neurons(const Plan& plan) {
    const std::string& file = plan.scene.file;
    if (plan.addresses > most_neurons)
        throw SceneError({file + ": " + std::to_string(plan.addresses) + " neurons, and a chip has " +
                          std::to_string(most_neurons) + " at most"});
    ChipNeurons all;
    all.start.reserve(plan.addresses);
    for (const PatchPlan& patch : plan.patches)
        for (std::uint32_t i = 0; i < patch.afferents(); ++i) {
            const FixedPointLif neuron = chip_neuron(patch.neuron_of(i), patch, file);
            if (all.groups.empty()) all.tick_ns = neuron.codes().tick_ns;
            if (neuron.codes().tick_ns != all.tick_ns)
                throw SceneError(
                    {file + ": patch \"" + patch.name +
                     "\": neuron.fixed_point.tick_us must be the same in all patches of a chip"});
            if (all.groups.empty() || all.groups.back().neuron.codes() != neuron.codes())
                all.groups.push_back({neuron, patch.first + i, 0});
            ++all.groups.back().count;
            all.start.push_back(patch.phases ? neuron.at_phase(patch.phases(i)) : neuron.rest());
        }
    return all;
}

ChipWidths chip_widths(const ChipNeurons& neurons) {
    ChipWidths widths;
    for (const ChipNeurons::Group& group : neurons.groups) {
        const FixedPointLif::Codes& c = group.neuron.codes();
        widths.u_bits = std::max(widths.u_bits, signed_bits(c.lowest, c.highest));
        widths.g_bits = std::max(widths.g_bits, unsigned_bits(static_cast<std::uint64_t>(c.g_most)));
        widths.refractory_bits = std::max(widths.refractory_bits, unsigned_bits(c.refractory_ticks));
        widths.input_bits = std::max(widths.input_bits, c.input_bits);
        widths.product_bits =
            std::max({widths.product_bits, product_bits(c), unsigned_bits(c.refractory_ticks) + 1});
    }
    return widths;
}

}  // namespace afferent
