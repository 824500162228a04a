// Question: what does a spike time cost, and how wrong is it, for each way to compute it?
#pragma once

#include <filesystem>
#include <iosfwd>
#include <vector>

#include "bench/error_scene.hpp"

namespace afferent::bench {

struct ErrorBench {
    std::filesystem::path out;
    bool quick = false;
    std::vector<ErrorScene> scenes;
};

// Writes error.csv, length.csv and, where gnuplot is installed, a picture for each scene; prints the tables.
// Throws std::runtime_error where a file cannot be written.
void run_error_bench(const ErrorBench& bench, std::ostream& report);

}  // namespace afferent::bench
