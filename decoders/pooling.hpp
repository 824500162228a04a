// How decoders by rates combine the afferents. Included by whoever builds a scene.
#pragma once

namespace afferent {

enum class Pooling {
    pooled,      // one curve from the grip force to the sum of all rates
    per_neuron,  // each neuron's rate through its own curve; then their mean
};

}  // namespace afferent
