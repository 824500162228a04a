// What a solver's errors do to the decoder: the error of the force that is estimated from its spikes.
#pragma once

#include <optional>

#include "bench/error_scene.hpp"

namespace afferent::bench {

// Nothing where the scene's force is not known. RMS in N over the scene's rows: spike rate in a window of 60
// ms, through the steady force–rate curve of each judged neuron, averaged over them.
std::optional<double> force_rms_n(const ErrorScene& scene, const Trains& trains);

}  // namespace afferent::bench
