// What the runtime is asked for at scale, as ratios of runs that take turns.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/scale_bench.hpp"
#include "bench/scale_ranks.hpp"

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
// The speed-up from one process to two ranks, and to two processes that exchange nothing, which is the most
// that the machine allows. `ranks` has both.
std::vector<ScaleTarget> two_ranks_targets(const ScaleRanks& ranks, bool quick);

}  // namespace afferent::bench
