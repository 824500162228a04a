// afferent tune --gain: the gain that suits each condition of a trial.
#pragma once

#include <cstdint>
#include <string>

#include "afferent/scene/scene.hpp"

namespace afferent {

struct GainOptions {
    bool wanted = false;
    std::string conditions = "rate,force,filter";
    std::uint64_t presentations = 2000;
    double most_dropped_pct = 2;
    std::int64_t held_out_seed = -1;  // < 0: the one after the scene's
};

// Prints the fronts, and writes them into the folder `out`, if there is one. Throws SceneError, Failure and
// Interrupted.
void tune_gain(const Scene& scene, const GainOptions& options, const std::string& out, bool json);

}  // namespace afferent
