// The solvers that are compared: our own, and what others would write.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/workload.hpp"

namespace afferent::bench {

// Why a solver has no result for a workload: it refuses it, does not converge, or would take too long.
class Unserved : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

class Solver {
  public:
    virtual ~Solver() = default;
    // Runs the workload from rest and appends the spikes of each neuron to its train, in order. Throws
    // Unserved.
    virtual void run(const Workload& workload, Trains& trains) = 0;
    // Does what is not timed, such as building populations. Called once, before any number of calls of the
    // others. Throws Unserved.
    virtual void prepare(const Workload&) {}
    // The same run, as it is timed: the spikes are delivered as to a user, and counted.
    virtual std::size_t count(const Workload& workload);
};

// A solver's name and its setting, a step in ms or a tolerance: "exact", "euler:0.1", "dopri5:1e-6".
struct SolverSpec {
    std::string name;
    double setting = 0;  // 0 where there is none

    std::string text() const;
};

// Does not look for the solver. Throws std::runtime_error where the setting is not a number > 0.
SolverSpec read_solver_spec(const std::string& text);
// Reads the same, and throws std::runtime_error, with the list of names, where there is no such solver.
SolverSpec parse_solver(const std::string& text);
std::unique_ptr<Solver> make_solver(const SolverSpec& spec);

// Names with what their setting means, for help texts.
std::vector<std::string> solver_names();

// One function for each family of solvers; null where the name is not one of theirs.
std::unique_ptr<Solver> make_exact_solver(const SolverSpec& spec);
std::unique_ptr<Solver> make_fixed_point_solver(const SolverSpec& spec);
std::unique_ptr<Solver> make_stepping_solver(const SolverSpec& spec);
std::unique_ptr<Solver> make_odeint_solver(const SolverSpec& spec);
std::unique_ptr<Solver> make_cvode_solver(const SolverSpec& spec);
// In the order in which they are shown.
std::vector<std::string> exact_solver_names();
std::vector<std::string> fixed_point_solver_names();
std::vector<std::string> stepping_solver_names();
std::vector<std::string> odeint_solver_names();
std::vector<std::string> cvode_solver_names();

}  // namespace afferent::bench
