#include "afferent/apps/neuron_command.hpp"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "afferent/apps/failure.hpp"
#include "afferent/io/files/table.hpp"
#include "bench/solver.hpp"

namespace afferent {
namespace {

struct Options {
    std::string drive;
    NeuronParameters parameters;
    double until_s = 0;
    std::size_t max_spikes = 0;
    std::string solver = "exact";
};

// Where a storm of spikes is cut off.
constexpr std::size_t default_max_spikes = 10'000'000;

TimePoint end_of(const Options& options, const bench::Workload& workload) {
    if (options.until_s > 0) return scene_start + rounded(Seconds(options.until_s));
    if (options.max_spikes > 0) return workload.times.back() + rounded(Seconds(1e6));
    if (workload.rows() > 1) return workload.times.back();
    throw Failure("a table of one row needs --until-s or --max-spikes");
}

bench::Workload workload(const Options& options) {
    auto read = read_table(options.drive);
    if (const auto* error = std::get_if<TableError>(&read)) throw Failure(error->message());
    Table& table = std::get<Table>(read);
    options.parameters.check();

    bench::Workload result;
    result.name = table.file;
    result.parameters = {options.parameters};
    result.neurons = table.columns.size();
    if (result.neurons == 0) throw Failure(table.file + ": needs a drive column beside time_s");
    result.times = std::move(table.times);
    result.drives_mv = std::move(table.values);
    result.max_spikes = options.max_spikes > 0 ? options.max_spikes : default_max_spikes;
    // Before the first row the drive is 0.
    if (result.times.front() > scene_start) {
        result.times.insert(result.times.begin(), scene_start);
        result.drives_mv.insert(result.drives_mv.begin(), result.neurons, 0.0);
    }
    result.until = end_of(options, result);
    while (result.rows() > 1 && result.times.back() >= result.until) {
        result.times.pop_back();
        result.drives_mv.resize(result.rows() * result.neurons);
    }
    return result;
}

void print(const bench::Trains& trains) {
    struct Line {
        bench::SpikeTime time;
        std::size_t address;
    };
    std::vector<Line> lines;
    for (std::size_t i = 0; i < trains.size(); ++i)
        for (const bench::SpikeTime& time : trains[i]) lines.push_back({time, i});
    std::stable_sort(lines.begin(), lines.end(),
                     [](const Line& a, const Line& b) { return (a.time - b.time).count() < 0; });
    std::puts("address,time_s");
    for (const Line& line : lines) {
        const auto ns =
            static_cast<long double>(line.time.near.time_since_epoch().count()) + line.time.rest.count();
        std::printf("%zu,%.17g\n", line.address, static_cast<double>(ns / 1'000'000'000));
    }
}

void run(const Options& options, const NeuronSolvers& solvers) {
    const bench::Workload drives = workload(options);
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
    print(trains);
}

}  // namespace

Command neuron_command(const NeuronSolvers& solvers) {
    const auto options = std::make_shared<Options>();
    NeuronParameters& neuron = options->parameters;
    return {
        .name = "neuron",
        .help = "Run one neuron for each drive column of a table, and print its spikes",
        .footer =
            "Prints address,time_s with the times as the solver has them, from v = v_r and g = 0.\n"
            "Example:\n  " +
            solvers.path + " --drive drive.csv --tau-m-ms 10 --delta-g 0.3 --until-s 2",
        .options =
            {
                option("--drive", options->drive,
                       "Table with time_s and one or more drive columns in mV, each row held until the next")
                    .required(),
                option("--tau-m-ms", neuron.tau_m_ms, "Time constant of the membrane").show_default(),
                option("--tau-g-ms", neuron.tau_g_ms, "Time constant of the adaptation").show_default(),
                option("--v-r-mv", neuron.v_r_mv, "Resting and reset potential").show_default(),
                option("--v-th-mv", neuron.v_th_mv, "Threshold").show_default(),
                option("--e-k-mv", neuron.e_k_mv, "Reversal potential of the adaptation").show_default(),
                option("--delta-g", neuron.delta_g, "What a spike adds to the adaptation").show_default(),
                option("--refractory-ms", neuron.refractory_ms, "Absolute refractory period").show_default(),
                option("--until-s", options->until_s, "When to end; by default at the last row")
                    .within(1e-9, 9e9),
                option("--max-spikes", options->max_spikes, "Of each neuron; then it is done (10 million)")
                    .positive(),
                option("--solver", options->solver, solvers.help).show_default(),
            },
        .run = [options, solvers] { run(*options, solvers); },
    };
}

}  // namespace afferent
