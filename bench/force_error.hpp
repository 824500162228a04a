// What the spikes of a solver cost the decoder: the error of the force estimated from them.
#pragma once

#include "bench/error_scene.hpp"

namespace afferent::bench {

// RMS in N over the scene's rows: spike rate in a window of 60 ms, through the steady force–rate curve of
// each judged neuron, averaged over them.
double force_rms_n(const ErrorScene& scene, const Trains& trains);

}  // namespace afferent::bench
