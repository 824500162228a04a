// How the scale benchmark shows what it found: as files, as pictures, and to a person.
#pragma once

#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "bench/scale_bench.hpp"
#include "bench/scale_ranks.hpp"
#include "bench/scale_targets.hpp"

namespace afferent::bench {

// What memory gave in the same run, by threads.
struct MemoryBandwidth {
    std::uint32_t threads;
    double bytes_per_s;  // read and written together
};

struct ScaleReport {
    std::vector<ScaleRow> rows = {};
    ScaleRanks ranks = {};
    std::vector<ScaleMemory> memory = {};
    std::vector<MemoryBandwidth> bandwidth = {};
    std::vector<ScaleTarget> targets = {};
    std::string no_energy = {};  // why there are no joules; empty: there are
};

// scale.csv, scale_memory.csv, scale_bandwidth.csv and scale_targets.csv. Throws std::runtime_error where
// they cannot be written.
void write_scale(const ScaleReport& report, const std::filesystem::path& folder);
// scale_elements, scale_activity and scale_threads, each .svg and .png, where gnuplot is installed. Throws
// std::runtime_error where it fails.
void draw_scale(const ScaleReport& report, const std::filesystem::path& folder);
void print_scale(const ScaleReport& report, std::ostream& out);

}  // namespace afferent::bench
