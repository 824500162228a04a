#include "afferent/apps/bench_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/error_bench.hpp"
#include "bench/latency_bench.hpp"
#include "bench/recorded_scene.hpp"
#include "bench/stability_bench.hpp"

namespace afferent {
namespace {

struct Options {
    std::filesystem::path out = "out/bench";
    bool quick = false;
};

std::shared_ptr<Options> add_options(CLI::App& command) {
    const auto options = std::make_shared<Options>();
    command.add_option("--out", options->out, "Folder for the results")->capture_default_str();
    command.add_flag("--quick", options->quick, "A part of it, in seconds");
    return options;
}

std::vector<bench::ErrorScene> error_scenes(const std::vector<std::string>& names, bool quick) {
    std::vector<bench::ErrorScene> own = bench::error_scenes(quick);
    if (names.empty()) return own;
    std::vector<bench::ErrorScene> scenes;
    for (const std::string& name : names) {
        const auto named = std::find_if(own.begin(), own.end(),
                                        [&](const auto& scene) { return scene.workload.name == name; });
        scenes.push_back(named != own.end() ? *named : recorded_scene(name, quick));
    }
    return scenes;
}

void add_error(CLI::App& bench) {
    CLI::App* command =
        bench.add_subcommand("error", "Run time against the error of spike times, for each solver");
    const auto options = add_options(*command);
    const auto names = std::make_shared<std::vector<std::string>>();
    command->add_option("SCENE", *names,
                        "The benchmark's own scenes by name, all if none, or scene files with the drives of "
                        "their neurons");
    command->footer(
        "Writes error.csv, length.csv and a picture for each scene.\n"
        "Its own scenes: grasp, noise, stiff, slow, population, crowd.\n"
        "Example:\n  afferent bench error --out out/error");
    command->callback([options, names] {
        bench::run_error_bench({options->out, options->quick, error_scenes(*names, options->quick)},
                               std::cout);
    });
}

void add_stability(CLI::App& bench) {
    CLI::App* command =
        bench.add_subcommand("stability", "Stiff, extreme and meaningless input, for each solver");
    const auto options = add_options(*command);
    command->footer(
        "Writes stability.csv. Fails if the exact solver does.\n"
        "Example:\n  afferent bench stability --out out/stability");
    command->callback([options] {
        const std::size_t failed = bench::run_stability_bench(options->out, options->quick, std::cout);
        if (failed > 0) throw Failure("the exact solver failed " + std::to_string(failed) + " cases");
    });
}

void add_latency(CLI::App& bench) {
    CLI::App* command = bench.add_subcommand("latency", "How long from the samples of a span to its packet");
    const auto scene = std::make_shared<std::string>();
    const auto quick = std::make_shared<bool>(false);
    const auto json = std::make_shared<bool>(false);
    command->add_option("SCENE", *scene, "The scene whose samples are replayed")->required();
    command->add_flag("--quick", *quick, "Fewer repetitions");
    command->add_flag("--json", *json, "Print the result as JSON");
    command->footer("Example:\n  afferent bench latency examples/grasp.txtpb");
    command->callback([=] {
        const bench::LatencyResult result =
            bench::run_latency_bench(Scene::from_file(*scene), *quick ? 3 : 50);
        Summary summary;
        summary["spans"] = result.spans;
        summary["median_us"] = result.all.median_us;
        summary["p99_us"] = result.all.p99_us;
        summary["largest_us"] = result.all.largest_us;
        summary["with_spikes_median_us"] = result.with_spikes.median_us;
        summary["with_spikes_p99_us"] = result.with_spikes.p99_us;
        summary["clock_us"] = result.clock_us;
        print(summary, *json);
    });
}

}  // namespace

void add_bench_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand("bench", "Measure, and check what is measured");
    command->require_subcommand(1);
    command->footer("Example:\n  afferent bench stability --quick");
    add_error(*command);
    add_stability(*command);
    add_latency(*command);
}

}  // namespace afferent
