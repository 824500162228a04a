#include "bench/solver.hpp"

#include <array>
#include <charconv>

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

std::string SolverSpec::text() const {
    if (setting == 0) return name;
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, setting).ptr;
    return name + ":" + std::string(digits, end);
}

std::vector<std::string> solver_names() {
    std::vector<std::string> all;
    for (const Family& family : families)
        for (std::string& name : family.names()) all.push_back(std::move(name));
    return all;
}

std::size_t Solver::count(const Workload& workload) {
    Trains trains(workload.neurons);
    run(workload, trains);
    std::size_t spikes = 0;
    for (const Train& train : trains) spikes += train.size();
    return spikes;
}

SolverSpec parse_solver(const std::string& text) {
    SolverSpec spec;
    const std::size_t colon = text.find(':');
    spec.name = text.substr(0, colon);
    if (colon != std::string::npos) {
        const char* end = text.data() + text.size();
        const auto [at, error] = std::from_chars(text.data() + colon + 1, end, spec.setting);
        if (error != std::errc() || at != end || !(spec.setting > 0))
            throw std::runtime_error("solver \"" + text + "\": what follows the colon must be a number > 0");
    }
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
