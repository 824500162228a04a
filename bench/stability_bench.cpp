#include "bench/stability_bench.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "bench/comparison.hpp"
#include "bench/solver.hpp"
#include "bench/stability_case.hpp"
#include "bench/table_file.hpp"
#include "bench/truth.hpp"

namespace afferent::bench {
namespace {

struct Verdict {
    std::string text;
    double max_error_s = 0;
    std::size_t missed = 0;
    std::size_t extra = 0;
};

// The outcomes of a case, in the order in which their counts are shown.
enum class Outcome { right, misplaced, missed, refused, accepted };
constexpr const char* outcome_names[] = {"right", "misplaced", "missed or extra", "refused",
                                         "accepted nonsense"};

// The dense form works on a clock: the same drive is given again and again.
Workload clocked(const Workload& workload) {
    const Duration length = workload.until - scene_start;
    if (workload.rows() > 1 || length > 10s) return workload;
    Workload result = workload;
    const auto scans = (length + Duration(5ms) - Duration(1)) / Duration(5ms);
    const Duration scan_interval = (length + Duration(scans - 1)) / scans;
    result.times.clear();
    result.drives_mv.assign(static_cast<std::size_t>(scans), workload.drives_mv.front());
    for (Duration::rep i = 0; i < scans; ++i) result.times.push_back(scene_start + i * scan_interval);
    result.until = scene_start + scans * scan_interval;
    return result;
}

Outcome judge(const SolverSpec& spec, const StabilityCase& item, const Train& truth, Verdict& verdict) {
    Trains trains(1);
    try {
        const Workload workload = spec.name == "dense" ? clocked(item.workload) : item.workload;
        const auto solver = make_solver(spec);
        solver->prepare(workload);
        solver->run(workload, trains);
    } catch (const Unserved& reason) {
        verdict.text = std::string("refused: ") + reason.what();
        return Outcome::refused;
    }
    if (!item.meaningful) {
        verdict.text = "accepted";
        return Outcome::accepted;
    }
    // True spikes are computed up to a limit; what a solver fires after the last of them is not compared.
    while (trains[0].size() > truth.size() && truth.size() == item.workload.max_spikes) trains[0].pop_back();
    Comparison errors;
    errors.add(truth, trains[0]);
    verdict.max_error_s = errors.max_s();
    verdict.missed = errors.missed;
    verdict.extra = errors.extra;
    const Outcome outcome = errors.missed + errors.extra > 0 ? Outcome::missed
                            : errors.worst_beyond_s > 0      ? Outcome::misplaced
                                                             : Outcome::right;
    verdict.text = outcome_names[static_cast<std::size_t>(outcome)];
    return outcome;
}

}  // namespace

std::size_t run_stability_bench(const std::filesystem::path& out, bool quick, std::ostream& report) {
    std::vector<SolverSpec> solvers{{"exact"},
                                    {"dense"},
                                    {"euler", 0.1},
                                    {"exponential-euler", 0.1},
                                    {"rk4-interpolated", 0.1},
                                    {"rk4-corrected", 0.1},
                                    {"dopri5", 1e-6},
                                    {"dopri5", 1e-10},
                                    {"rosenbrock", 1e-6}};
    for (const std::string& name : cvode_solver_names()) solvers.push_back({name, 1e-8});

    struct Tally {
        std::size_t counts[std::size(outcome_names)] = {};
        double worst_s = 0;
    };
    std::vector<Tally> tallies(solvers.size());
    TableFile file(out / "stability.csv", {"case", "solver", "verdict", "max_error_s", "missed", "extra"});
    std::vector<StabilityCase> cases = stability_cases(quick);
    for (StabilityCase& item : cases) {
        Workload& workload = item.workload;
        Train truth;
        if (item.meaningful) truth = true_train(workload, 0);
        // Held long enough for a spike, so that stepping solvers get one too.
        if (workload.rows() == 1) {
            const Duration last = truth.empty() ? Duration(1s) : truth.back().near - scene_start;
            if (truth.size() == workload.max_spikes || truth.empty())
                workload.until = std::min(workload.until, scene_start + last + last / 100 + Duration(1000));
        }
        workload.most_steps = quick ? 3e4 : 1e5;
        for (std::size_t i = 0; i < solvers.size(); ++i) {
            Verdict verdict;
            const Outcome outcome = judge(solvers[i], item, truth, verdict);
            ++tallies[i].counts[static_cast<std::size_t>(outcome)];
            tallies[i].worst_s = std::max(tallies[i].worst_s, verdict.max_error_s);
            file.row({workload.name, solvers[i].text(), verdict.text, number(verdict.max_error_s),
                      std::to_string(verdict.missed), std::to_string(verdict.extra)});
            if (i == 0 &&
                (outcome == Outcome::misplaced || outcome == Outcome::missed || outcome == Outcome::accepted))
                report << "exact fails: " << workload.name << ": " << verdict.text << ", "
                       << verdict.max_error_s << " s, " << verdict.missed << " missed, " << verdict.extra
                       << " extra\n";
        }
    }
    file.close();

    report << cases.size()
           << " cases; right is within max(1 ns, 1e-12 of the time), nothing missed, nothing extra\n"
           << std::left << std::setw(24) << "solver" << std::right;
    for (const char* name : outcome_names) report << std::setw(19) << name;
    report << std::setw(19) << "worst error s" << '\n';
    for (std::size_t i = 0; i < solvers.size(); ++i) {
        report << std::left << std::setw(24) << solvers[i].text() << std::right;
        for (const std::size_t count : tallies[i].counts) report << std::setw(19) << count;
        report << std::setw(19) << std::setprecision(3) << tallies[i].worst_s << '\n';
    }
    const auto& exact = tallies.front().counts;
    return exact[static_cast<std::size_t>(Outcome::misplaced)] +
           exact[static_cast<std::size_t>(Outcome::missed)] +
           exact[static_cast<std::size_t>(Outcome::accepted)];
}

}  // namespace afferent::bench
