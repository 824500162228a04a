// What does not depend on the list of solvers, for programs that link only some of them.
#include <charconv>

#include "bench/solver.hpp"

namespace afferent::bench {

std::string SolverSpec::text() const {
    if (setting == 0) return name;
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, setting).ptr;
    return name + ":" + std::string(digits, end);
}

std::size_t Solver::count(const Workload& workload) {
    Trains trains(workload.neurons);
    run(workload, trains);
    std::size_t spikes = 0;
    for (const Train& train : trains) spikes += train.size();
    return spikes;
}

SolverSpec read_solver_spec(const std::string& text) {
    SolverSpec spec;
    const std::size_t colon = text.find(':');
    spec.name = text.substr(0, colon);
    if (colon != std::string::npos) {
        const char* end = text.data() + text.size();
        const auto [at, error] = std::from_chars(text.data() + colon + 1, end, spec.setting);
        if (error != std::errc() || at != end || !(spec.setting > 0))
            throw std::runtime_error("solver \"" + text + "\": what follows the colon must be a number > 0");
    }
    return spec;
}

}  // namespace afferent::bench
