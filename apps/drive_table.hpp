// Turns a table of drives into a workload for a solver.
#pragma once

#include <cstddef>
#include <string>

#include "bench/workload.hpp"

namespace afferent {

// One neuron for each column beside time_s, all with these parameters.
struct DriveTable {
    std::string file;
    LifParameters parameters;
    double until_s = 0;          // 0: at the last row
    std::size_t max_spikes = 0;  // of each neuron; 0: a bound that only a storm of spikes reaches
};

// Throws Failure where the table cannot be read or has no end, ParameterError as parameters.check().
bench::Workload workload(const DriveTable& table);

}  // namespace afferent
