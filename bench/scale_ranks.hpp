// What a population costs in several processes, which MPI starts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/scale_bench.hpp"

namespace afferent::bench {

struct ScaleRanks {
    // Each row is the median of repeats of `afferent run`, sensors included, by the wall clock of rank 0 or
    // of the only process. The repeats of all rows take turns.
    std::vector<ScaleRow> rows = {};
    // A frame of two processes side by side that exchange nothing, each with half of the elements, by the
    // slower of them: two ranks take as long at least on this machine. The least of the repeats; 0 on one
    // processor.
    double halves_s = 0;
    std::string unavailable = {};  // why there are none; empty: there are
};

// 1, 2, 4, ... processes and as many as the machine has processors, all elements touched, the plan's own
// form, one thread each. `program` is afferent, with afferent-ranks beside it. Throws std::runtime_error
// where a run fails, or has other events than one process has.
ScaleRanks measure_scale_ranks(const std::filesystem::path& program, bool quick,
                               const std::function<void(double)>& progress);

// The number of an entry of a JSON object. Throws std::runtime_error where there is none.
double number_in_json(const std::string& json, const std::string& entry);

}  // namespace afferent::bench
