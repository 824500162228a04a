// Question: how much run time does a spike cost, and how wrong is its time, for each solver?
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
