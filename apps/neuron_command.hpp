// afferent neuron: one neuron for each drive column of a table, to compare with your own script; and afferent
// bench neuron, which has the competitors' solvers too.
#pragma once

#include <memory>
#include <string>

#include "afferent/apps/cli.hpp"
#include "bench/solver.hpp"

namespace afferent {

struct NeuronSolvers {
    std::string help;  // of --solver: which there are
    // Returns null or throws if there is no such solver.
    std::unique_ptr<bench::Solver> (*make)(const bench::SolverSpec&);
    std::string path = "afferent neuron";  // of the command, for its example
};

Command neuron_command(const NeuronSolvers& solvers);

}  // namespace afferent
