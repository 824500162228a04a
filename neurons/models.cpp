#include "afferent/neurons/models.hpp"

namespace afferent {

NeuronModel smallest_model(const NeuronParameters& parameters) {
    parameters.check();
    const bool adapts = parameters.delta_g > 0;
    const bool rests = parameters.refractory_ms > 0;
    if (adapts && rests) return Refractory<AdaptingLif>(parameters);
    if (adapts) return AdaptingLif(parameters);
    if (rests) return Refractory<Lif>(parameters);
    return Lif(parameters);
}

}  // namespace afferent
