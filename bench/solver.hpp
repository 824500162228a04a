// The solvers that are compared: ours, and what others would write.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/workload.hpp"

namespace afferent::bench {

// It does not serve this workload, and says why: it refuses it, does not converge, or would take for ever.
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
    // Does what is not to be timed, such as building populations. Comes before the others, which may then be
    // called many times. Throws Unserved.
    virtual void prepare(const Workload&) {}
    // The same run, timed: the spikes are delivered and counted, as the solver's user would take them.
    virtual std::size_t count(const Workload& workload);
};

// A solver's name and its setting, a step in ms or a tolerance: "exact", "euler:0.1", "dopri5:1e-6".
struct SolverSpec {
    std::string name;
    double setting = 0;  // 0 where there is none

    std::string text() const;
};

// Throws std::runtime_error with the list of names, where there is none such.
SolverSpec parse_solver(const std::string& text);
std::unique_ptr<Solver> make_solver(const SolverSpec& spec);

// Names with what their setting means, for help texts.
std::vector<std::string> solver_names();

// The families; nothing where the name is not theirs.
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
