#include "afferent/apps/neuron_command.hpp"

#include <CLI/CLI.hpp>
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

// What a storm of spikes is cut off at.
constexpr std::size_t default_max_spikes = 10'000'000;

TimePoint end_of(const Options& options, const bench::Workload& workload) {
    if (options.until_s > 0) return scene_start + rounded(Seconds(options.until_s));
    if (options.max_spikes > 0) return workload.times.back() + rounded(Seconds(1e6));
    if (workload.rows() > 1) return workload.times.back();
    throw Failure("a drive that is held for good needs --until-s or --max-spikes");
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

void run(const Options& options) {
    const bench::Workload drives = workload(options);
    const bench::SolverSpec spec = bench::parse_solver(options.solver);
    const auto solver = bench::make_solver(spec);
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

void add_neuron_command(CLI::App& app) {
    const auto options = std::make_shared<Options>();
    NeuronParameters& neuron = options->parameters;
    CLI::App* command =
        app.add_subcommand("neuron", "Run one neuron for each drive column of a table, and print its spikes");
    command
        ->add_option("--drive", options->drive,
                     "Table with time_s and one or more drive columns in mV, each row held until the next")
        ->required();
    command->add_option("--tau-m-ms", neuron.tau_m_ms, "Time constant of the membrane")
        ->capture_default_str();
    command->add_option("--tau-g-ms", neuron.tau_g_ms, "Time constant of the adaptation")
        ->capture_default_str();
    command->add_option("--v-r-mv", neuron.v_r_mv, "Resting and reset potential")->capture_default_str();
    command->add_option("--v-th-mv", neuron.v_th_mv, "Threshold")->capture_default_str();
    command->add_option("--e-k-mv", neuron.e_k_mv, "Reversal potential of the adaptation")
        ->capture_default_str();
    command->add_option("--delta-g", neuron.delta_g, "What a spike adds to the adaptation")
        ->capture_default_str();
    command->add_option("--refractory-ms", neuron.refractory_ms, "Absolute refractory period")
        ->capture_default_str();
    command->add_option("--until-s", options->until_s, "When to end; by default at the last row")
        ->check(CLI::Range(1e-9, 9e9));
    command->add_option("--max-spikes", options->max_spikes, "Of each neuron; then it is done (10 million)")
        ->check(CLI::PositiveNumber);
    std::string names;
    for (const std::string& name : bench::solver_names()) names += (names.empty() ? "" : ", ") + name;
    command
        ->add_option("--solver", options->solver,
                     "One of " + names + "; after a colon a step in ms or a tolerance, as in euler:0.1")
        ->capture_default_str();
    command->footer(
        "Prints address,time_s with the times as the solver has them, from v = v_r and g = 0.\n"
        "Example:\n  afferent neuron --drive drive.csv --tau-m-ms 10 --delta-g 0.3 --until-s 2");
    command->callback([options] { run(*options); });
}

}  // namespace afferent
