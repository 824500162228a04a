#include "afferent/apps/neuron_command.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "afferent/apps/drive_table.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/solver.hpp"

namespace afferent {
namespace {

struct NeuronOptions {
    DriveTable table;
    std::string solver = "exact";
    bool json = false;
};

void print(const bench::Trains& trains, bool json) {
    struct Line {
        bench::SpikeTime time;
        std::size_t address;
    };
    std::vector<Line> lines;
    for (std::size_t i = 0; i < trains.size(); ++i)
        for (const bench::SpikeTime& time : trains[i]) lines.push_back({time, i});
    std::stable_sort(lines.begin(), lines.end(),
                     [](const Line& a, const Line& b) { return (a.time - b.time).count() < 0; });
    const auto time_s = [](const bench::SpikeTime& time) {
        const auto ns = static_cast<long double>(time.near.time_since_epoch().count()) + time.rest.count();
        return static_cast<double>(ns / 1'000'000'000);
    };
    if (json) {
        Summary::List spikes;
        for (const Line& line : lines)
            spikes.push_back({{"address", line.address}, {"time_s", time_s(line.time)}});
        return afferent::print(Summary{{"spikes", spikes}}, true);
    }
    std::puts("address,time_s");
    for (const Line& line : lines) std::printf("%zu,%.17g\n", line.address, time_s(line.time));
}

void run(const NeuronOptions& options, const NeuronSolvers& solvers) {
    const bench::Workload drives = workload(options.table);
    const bench::SolverSpec spec = bench::read_solver_spec(options.solver);
    const auto solver = solvers.make(spec);
    if (!solver) throw Failure("--solver: there is no " + spec.name + " here; there is " + solvers.help);
    bench::Trains trains(drives.neurons);
    try {
        solver->prepare(drives);
        solver->run(drives, trains);
    } catch (const bench::Unserved& reason) {
        throw Failure(spec.text() + " does not serve this: " + reason.what());
    }
    print(trains, options.json);
}

}  // namespace

Command neuron_command(const NeuronSolvers& solvers) {
    const auto options = std::make_shared<NeuronOptions>();
    LifParameters& neuron = options->table.parameters;
    return {
        .name = "neuron",
        .help = "Run one neuron for each drive column of a table, and print its spikes",
        .footer =
            "Prints address,time_s with the times as the solver has them, from v = v_r and g = 0.\n"
            "Example:\n  " +
            solvers.path + " --drive examples/data/drive.csv --tau-m-ms 10 --delta-g 0.3 --until-s 2",
        .options =
            {
                option("--drive", options->table.file,
                       "Table with time_s and one or more drive columns in mV, each row held until the next")
                    .required(),
                option("--tau-m-ms", neuron.tau_m_ms, "Time constant of the membrane").show_default(),
                option("--tau-g-ms", neuron.tau_g_ms, "Time constant of the adaptation").show_default(),
                option("--v-r-mv", neuron.v_r_mv, "Resting and reset potential").show_default(),
                option("--v-th-mv", neuron.v_th_mv, "Threshold").show_default(),
                option("--e-k-mv", neuron.e_k_mv, "Reversal potential of the adaptation").show_default(),
                option("--delta-g", neuron.delta_g, "What a spike adds to the adaptation").show_default(),
                option("--refractory-ms", neuron.refractory_ms, "Absolute refractory period").show_default(),
                option("--until-s", options->table.until_s, "When to end; by default at the last row")
                    .within(1e-9, 9e9),
                option("--max-spikes", options->table.max_spikes,
                       "Of each neuron; then it is done (10 million)")
                    .positive(),
                option("--solver", options->solver, solvers.help).show_default(),
                flag("--json", options->json, "Print the spikes as JSON"),
            },
        .run = [options, solvers] { run(*options, solvers); },
    };
}

}  // namespace afferent
