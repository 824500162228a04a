// The neurons of a scene as a chip has them: integers, in groups of the same constants.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/neurons/fixed_point.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

struct ChipNeurons {
    // Neurons with addresses from begin on that have the same constants.
    struct Group {
        FixedPointLif neuron;
        Address begin;
        Address count;
    };
    std::vector<Group> groups;                // together all addresses of the scene, in order
    std::vector<FixedPointLif::State> start;  // by address
    std::int64_t tick_ns = 0;                 // of all of them

    Address count() const noexcept { return static_cast<Address>(start.size()); }
    const FixedPointLif& neuron(Address address) const noexcept;
    // False where neurons begin at different phases.
    bool begins_at_rest() const noexcept;
};

// Throws SceneError where a patch's neurons are not `fixed_point`, where patches differ in their tick, and
// where there are more neurons than 65,536.
ChipNeurons chip_neurons(const Plan& plan);

// The largest of what is computed, and so the types that hold it. For every state and input that there can
// be.
struct ChipWidths {
    std::uint32_t u_bits = 0;           // signed
    std::uint32_t g_bits = 0;           // unsigned
    std::uint32_t refractory_bits = 0;  // unsigned
    std::uint32_t input_bits = 0;       // signed
    std::uint32_t product_bits = 0;     // signed, with what rounding adds
};
ChipWidths chip_widths(const ChipNeurons& neurons);

}  // namespace afferent
