#include "bench/solver.hpp"

#include <array>

namespace afferent::bench {
namespace {

struct Family {
    std::vector<std::string> (*names)();
    std::unique_ptr<Solver> (*make)(const SolverSpec&);
};

constexpr std::array families{
    Family{exact_solver_names, make_exact_solver},
    Family{fixed_point_solver_names, make_fixed_point_solver},
    Family{stepping_solver_names, make_stepping_solver},
    Family{odeint_solver_names, make_odeint_solver},
    Family{cvode_solver_names, make_cvode_solver},
};

}  // namespace

std::vector<std::string> solver_names() {
    std::vector<std::string> all;
    for (const Family& family : families)
        for (std::string& name : family.names()) all.push_back(std::move(name));
    return all;
}

SolverSpec parse_solver(const std::string& text) {
    SolverSpec spec = read_solver_spec(text);
    make_solver(spec);
    return spec;
}

std::unique_ptr<Solver> make_solver(const SolverSpec& spec) {
    for (const Family& family : families)
        if (auto solver = family.make(spec)) return solver;
    std::string known;
    for (const std::string& name : solver_names()) known += (known.empty() ? "" : ", ") + name;
    throw std::runtime_error("there is no solver \"" + spec.name + "\"; there are " + known);
}

}  // namespace afferent::bench
