// Runs a workload through a population that predicts its spikes.
#pragma once

#include <cstdint>
#include <limits>

#include "afferent/runtime/parameter_error.hpp"
#include "bench/workload.hpp"

namespace afferent::bench {

inline void note(const Workload& workload, Trains& trains, std::size_t neuron, SpikeTime spike) {
    if (trains[neuron].size() < workload.max_spikes) trains[neuron].push_back(spike);
}

template <class Population, class Sink>
void run_sparse(Population& population, const Workload& workload, Sink&& sink) {
    population.reset();
    for (std::size_t row = 0; row < workload.rows(); ++row) {
        for (std::size_t i = 0; i < workload.neurons; ++i)
            population.set_drive(static_cast<std::uint32_t>(i), workload.times[row],
                                 workload.drive_mv(row, i));
        population.advance(workload.end(row), sink);
    }
}

// Populations trust their drives, so those from outside are checked first.
inline void check_drives(const Workload& workload) {
    for (const double drive_mv : workload.drives_mv) require(true, "drive_mv", "finite", drive_mv);
}

// The guard against storms stops a neuron that has fired as often as the workload asks for.
inline std::uint32_t spike_limit(const Workload& workload) {
    constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
    return workload.max_spikes < most ? static_cast<std::uint32_t>(workload.max_spikes) : most;
}

}  // namespace afferent::bench
