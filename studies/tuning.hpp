// What makes one afferent of a scene fire, as a physiologist would find it with a probe: its field, tuning
// curve, rate against depth, and the intervals of a hold.
//
//     auto tuning = tuning_of(plan, 17);
//     if (tuning) print(tuning.value(), std::cout);
//
// The command `afferent tuning` prints this, and Python hands it on.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/position.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

struct TuningOptions {
    double radius_mm = 0.5;  // of the probe, which has a flat end
    double hold_mm = 1;      // depth at which intervals are counted
    // Samples a second; none: as many as the scene's sensors have.
    std::optional<double> rate_hz = {};
    // Called with the part that is done.
    std::function<void(double fraction)> progress = {};
};

struct AfferentTuning {
    // What is not reached at 3 mm, where a probe would go through the skin, is nothing.
    using Amplitude = std::optional<double>;

    struct Frequency {
        double hz;
        Amplitude threshold_um;     // from which it fires at all
        Amplitude once_a_cycle_um;  // from which it fires as often as the probe vibrates
    };
    struct Depth {
        double depth_mm;
        double onset_hz;  // of the first tenth of a second
        double held_hz;   // of the second half of a second
    };
    // Spikes of the first tenth of a second under a probe away from the afferent.
    struct Offset {
        double offset_mm;
        double along_x;
        double along_y;
    };

    Address address = 0;
    std::string patch;
    std::string kind;  // "SA1", or by its encoder
    Position place;    // on the map of the body
    double rate_hz = 0;
    double radius_mm = 0;
    // Of an indentation within 50 ms.
    Amplitude threshold_um = {};
    double field_depth_um = 0;  // 4.5 times the threshold
    double field_mm2 = 0;       // where the probe makes it fire at that depth
    std::vector<Offset> field = {};
    std::vector<Frequency> frequencies = {};
    std::vector<Depth> depths = {};
    double hold_mm = 0;
    // Between the spikes of a hold, from half a second to five seconds after its begin.
    std::vector<double> intervals_ms = {};
};

// A flat punch on the elastic half-space of the scene, perpendicular to the skin, at the place of that
// afferent; sensors are perfect. Errors are not_allowed: no such address, a patch without an outline, or an
// afferent that fires without bounds.
Result<AfferentTuning> tuning_of(const Plan& plan, Address address, const TuningOptions& options = {});

// The same of each afferent of a patch, by address; some half a second each.
Result<std::vector<AfferentTuning>> tuning_of_patch(const Plan& plan, const std::string& patch,
                                                    const TuningOptions& options = {});

}  // namespace afferent
