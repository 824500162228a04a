// What the runtime is asked for at scale, as ratios of runs that take turns.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/scale_bench.hpp"

namespace afferent::bench {

struct ScaleTarget {
    std::string what;
    double value;
    std::string unit = {};
    // None: nothing is asked of it, or not at this size.
    std::optional<double> asked = {};
    bool at_least = false;  // or at most

    bool met() const noexcept { return !asked || (at_least ? value >= *asked : value <= *asked); }
};

// The memory of a fully touched population, once it has settled.
struct ScaleMemory {
    ScaleRun run;
    double bytes_per_element;
    double resident_bytes_per_element;  // by the system
};

// At full size, or at a fifth of it.
std::vector<ScaleMemory> measure_scale_memory(bool quick, const std::function<void(double)>& progress);
std::vector<ScaleTarget> measure_scale_targets(const std::vector<ScaleMemory>& memory, bool quick,
                                               const std::function<void(double)>& progress);
// The speed-up from rows[0], measured in one process, to rows[1], measured in two.
ScaleTarget two_ranks_target(const std::vector<ScaleRow>& rows, bool quick);

}  // namespace afferent::bench
