#include "afferent/apps/bench_commands.hpp"

#include <charconv>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/chip_bench.hpp"
#include "bench/contact_latency.hpp"
#include "bench/error_bench.hpp"
#include "bench/faults_bench.hpp"
#include "bench/latency_bench.hpp"
#include "bench/recorded_scene.hpp"
#include "bench/stability_bench.hpp"
#include "bench/table_file.hpp"

namespace afferent {
namespace {

struct BenchOptions {
    std::filesystem::path out = "out/bench";
    bool quick = false;
    bool json = false;

    // The report for people, or nobody's.
    std::ostream& report() { return json ? nobody : std::cout; }

  private:
    std::ostream nobody{nullptr};
};

// The rows of tables that have been written, under the tables' names.
void print_tables(const std::filesystem::path& folder, std::initializer_list<const char*> names) {
    Summary tables;
    for (const char* const name : names) {
        Summary::List rows;
        for (const auto& row : bench::read_rows(folder / (name + std::string(".csv")))) {
            Summary entry;
            for (const auto& [column, cell] : row) {
                double value = 0;
                const char* const end = cell.data() + cell.size();
                const auto [at, error] = std::from_chars(cell.data(), end, value);
                const bool is_number = error == std::errc() && at == end;
                entry[column] = cell.empty() ? Summary() : is_number ? Summary(value) : Summary(cell);
            }
            rows.push_back(std::move(entry));
        }
        tables[name] = std::move(rows);
    }
    print(tables, true);
}

std::vector<Option> list(BenchOptions& options) {
    return {
        option("--out", options.out, "Folder for the results").show_default(),
        flag("--quick", options.quick, "A part of it, in seconds"),
        flag("--json", options.json, "Print the tables as JSON"),
    };
}

}  // namespace

Command bench_chip_command() {
    const auto options = std::make_shared<BenchOptions>();
    const auto scene = std::make_shared<std::filesystem::path>(bench::ChipBench().scene);
    std::vector<Option> list = afferent::list(*options);
    list.push_back(option("--scene", *scene, "Scene whose exported code is measured").show_default());
    return {
        .name = "chip",
        .help = "What a neuron in firmware or on an FPGA costs, and how wrong it is",
        .footer =
            "Writes chip.csv and its picture, and what was exported into folders. Instructions, flash, cells "
            "and "
            "clock need\nthe programs of scripts/install-dependencies.sh chip.\n"
            "Example:\n  afferent bench chip --out out/chip_bench",
        .options = std::move(list),
        .run =
            [options, scene] {
                Progress progress("bench chip");
                bench::run_chip_bench(
                    {options->out, options->quick, *scene, [&](double part) { progress.at(part); }},
                    options->report());
                if (options->json) print_tables(options->out, {"chip"});
            },
    };
}

Command bench_error_command() {
    const auto options = std::make_shared<BenchOptions>();
    const auto names = std::make_shared<std::vector<std::string>>();
    std::vector<Option> list = afferent::list(*options);
    list.push_back(positional("SCENE", *names,
                              "The benchmark's own scenes by name, all if none, or scene files with the "
                              "drives of their neurons"));
    return {
        .name = "error",
        .help = "Run time against the error of spike times, for each solver",
        .footer =
            "Writes error.csv, length.csv and a picture for each scene.\n"
            "Its own scenes: grasp, noise, stiff, slow, population, crowd.\n"
            "Example:\n  afferent bench error --out out/error",
        .options = std::move(list),
        .run =
            [options, names] {
                bench::run_error_bench({options->out, options->quick, named_scenes(*names, options->quick)},
                                       options->report());
                if (options->json) print_tables(options->out, {"error", "length"});
            },
    };
}

Command bench_stability_command() {
    const auto options = std::make_shared<BenchOptions>();
    return {
        .name = "stability",
        .help = "Stiff, extreme and meaningless input, for each solver",
        .footer =
            "Writes stability.csv. Fails if the exact solver does.\n"
            "Example:\n  afferent bench stability --out out/stability",
        .options = list(*options),
        .run =
            [options] {
                const std::size_t failed =
                    bench::run_stability_bench(options->out, options->quick, options->report());
                if (options->json) print_tables(options->out, {"stability"});
                if (failed > 0) throw Failure("the exact solver failed " + std::to_string(failed) + " cases");
            },
    };
}

namespace {

void bench_contact_latency(const Scene& scene, std::uint32_t presentations, bool json) {
    Progress progress("bench latency");
    const std::vector<bench::ContactLatency> measured =
        bench::measure_contact_latency(scene, presentations, [&](double done) { progress.at(done); });
    if (!json) return bench::print_contact_latency(measured, std::cout);
    const auto or_null = [](const std::optional<double>& value) {
        return value ? Summary(*value) : Summary();
    };
    Summary::List rows;
    for (const bench::ContactLatency& row : measured) {
        Summary entry;
        entry["decoder"] = row.condition;
        entry["chain"] = row.chain;
        entry["told_median_ms"] = or_null(row.told_median_ms);
        entry["answered"] = row.answered;
        entry["p10_ms"] = or_null(row.p10_ms);
        entry["median_ms"] = or_null(row.median_ms);
        entry["p90_ms"] = or_null(row.p90_ms);
        entry["budget_ms"] = row.budget_ms;
        rows.push_back(std::move(entry));
    }
    Summary summary;
    summary["presentations"] = presentations;
    summary["contact_latency"] = std::move(rows);
    print(summary, true);
}

}  // namespace

Command bench_latency_command() {
    struct LatencyOptions {
        std::string scene;
        bool contact = false;
        bool quick = false;
        bool json = false;
    };
    const auto options = std::make_shared<LatencyOptions>();
    return {
        .name = "latency",
        .help = "How long from the samples of a span to its packet, or from a contact to its command",
        .footer =
            "Examples:\n"
            "  afferent bench latency examples/grasp.txtpb\n"
            "  afferent bench latency examples/trial_in_hand.txtpb --contact",
        .options =
            {
                positional("SCENE", options->scene, "The scene whose samples are replayed").required(),
                flag("--contact", options->contact,
                     "From the contact to the command in the scene's trial, for each decoder, in virtual "
                     "time"),
                flag("--quick", options->quick, "Fewer repetitions"),
                flag("--json", options->json, "Print the result as JSON"),
            },
        .run =
            [options] {
                if (options->contact)
                    return bench_contact_latency(Scene::from_file(options->scene), options->quick ? 60 : 600,
                                                 options->json);
                const bench::LatencyResult result =
                    bench::run_latency_bench(Scene::from_file(options->scene), options->quick ? 3 : 50);
                Summary summary;
                summary["spans"] = result.spans;
                summary["median_us"] = result.all.median_us;
                summary["p99_us"] = result.all.p99_us;
                summary["largest_us"] = result.all.largest_us;
                summary["with_spikes_median_us"] = result.with_spikes.median_us;
                summary["with_spikes_p99_us"] = result.with_spikes.p99_us;
                summary["clock_us"] = result.clock_us;
                print(summary, options->json);
            },
    };
}

Command bench_faults_command() {
    const auto options = std::make_shared<BenchOptions>();
    return {
        .name = "faults",
        .help = "Floods and hostile peers against a hand: its steps, events, memory and grip",
        .footer =
            "Writes faults.csv. Fails if the grip was not safe without a coprocessor.\n"
            "Example:\n  afferent bench faults --out out/faults",
        .options = list(*options),
        .run =
            [options] {
                const auto program =
                    std::filesystem::read_symlink("/proc/self/exe").parent_path() / "afferent";
                const auto wrong =
                    bench::run_faults_bench({program, options->out, options->quick}, options->report());
                if (options->json) print_tables(options->out, {"faults"});
                if (wrong.empty()) return;
                std::string rows;
                for (const auto& row : wrong)
                    rows += "\n  " + row.transport + ", " + row.fault + ": " + row.grip_state;
                throw Failure("the grip was not safe without a coprocessor:" + rows);
            },
    };
}

}  // namespace afferent
