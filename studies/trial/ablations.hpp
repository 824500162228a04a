// A trial with a part of the chain taken out or added: what does that part do for the objects?
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct Ablation {
    std::string_view name;
    std::string_view words;  // what a picture calls it
    // The conditions that it changes anything of, for a scene of sustained neurons.
    std::vector<std::string> conditions;
    // The scene with it, for the decoder of that condition.
    Scene (*applied)(const Scene& scene, std::string_view condition);
};

// All there are, by name:
//
//     no_adaptation      neurons that do not adapt, tuned to the same force
//     one_neuron         one neuron on the summed grip force, as in the paper
//     transient_added    transient neurons on the same elements, which the filter reads too
std::span<const Ablation> ablations();
// Null if there is none of that name.
const Ablation* find_ablation(std::string_view name);

}  // namespace afferent
