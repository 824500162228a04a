// afferent bench scale: what does a population cost?
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "afferent/apps/bench_commands.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/energy_meter.hpp"
#include "bench/machine_memory.hpp"
#include "bench/scale_bench.hpp"
#include "bench/scale_export.hpp"
#include "bench/scale_ranks.hpp"
#include "bench/scale_tables.hpp"
#include "bench/scale_targets.hpp"

namespace afferent {
namespace {

using namespace bench;

struct BenchScaleOptions {
    std::string out;
    std::string export_to;
    std::vector<std::uint32_t> elements;
    bool quick = false;
    bool json = false;
};

// More than any cache of a processor holds, or hardly more than most of them do.
std::size_t bandwidth_bytes(bool quick) { return (quick ? 128UL : 1024UL) << 20; }

ScaleReport measure(const BenchScaleOptions& options) {
    ScaleReport report{.no_energy = EnergyMeter().unavailable()};
    // Saved after each part, so that an interrupt loses only the part that it breaks off.
    const auto save = [&] {
        if (!options.out.empty()) write_scale(report, options.out);
    };
    ScaleOptions scale{.quick = options.quick};
    if (options.quick) scale.elements = {9, 1000, 20'000};
    if (!options.elements.empty()) scale.elements = options.elements;
    for (const std::uint32_t threads : scale_threads())
        report.bandwidth.push_back({threads, memory_bytes_per_s(threads, bandwidth_bytes(options.quick))});
    {
        Progress progress("bench scale");
        report.rows = measure_scale(scale, [&](double fraction) { progress.at(fraction); });
        save();
    }
    {
        Progress progress("ranks");
        const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "afferent";
        report.ranks =
            measure_scale_ranks(program, options.quick, [&](double fraction) { progress.at(fraction); });
        save();
    }
    {
        Progress progress("memory");
        report.memory = measure_scale_memory(options.quick, [&](double fraction) { progress.at(fraction); });
    }
    Progress progress("targets");
    report.targets =
        measure_scale_targets(report.memory, options.quick, [&](double fraction) { progress.at(fraction); });
    if (report.ranks.rows.size() > 1)
        for (const ScaleTarget& each : two_ranks_targets(report.ranks, options.quick))
            report.targets.push_back(each);
    save();
    return report;
}

Summary summarise(const ScaleReport& report) {
    Summary summary;
    const auto add = [&](const ScaleRow& row, const char* measured) {
        Summary entry;
        entry["elements"] = row.run.population.elements;
        entry["active_fraction"] = row.run.population.active_fraction;
        entry["contact"] = name(row.run.population.contact);
        entry["schedule"] = name(row.run.form);
        entry["threads"] = row.run.threads;
        entry["ranks"] = row.ranks;
        entry["realtime_factor"] = row.cost.realtime_factor();
        entry["ns_per_element_frame"] = row.ns();
        entry["events_per_s"] = row.cost.events_per_s();
        entry["bytes_per_element"] = row.bytes_per_element();
        if (row.cost.joules_per_event) entry["nj_per_event"] = 1e9 * *row.cost.joules_per_event;
        entry["measured"] = measured;
        summary["scale"].push_back(entry);
    };
    for (const ScaleRow& row : report.rows) add(row, "embedded");
    for (const ScaleRow& row : report.ranks.rows) add(row, "run");
    summary["ranks"] = report.ranks.unavailable.empty() ? "measured" : report.ranks.unavailable;
    for (const ScaleCrossing& crossing : crossings(report.rows)) {
        Summary entry;
        entry["elements"] = crossing.elements;
        entry["active_fraction"] = crossing.fraction ? Summary(*crossing.fraction) : Summary();
        summary["crossing"].push_back(entry);
    }
    for (const ScaleMemory& each : report.memory)
        summary["memory"].push_back({{"elements", each.run.population.elements},
                                     {"schedule", name(each.run.form)},
                                     {"adapts", each.run.population.adapts},
                                     {"differs", each.run.population.differs},
                                     {"bytes_per_element", each.bytes_per_element},
                                     {"resident_bytes_per_element", each.resident_bytes_per_element}});
    for (const MemoryBandwidth& each : report.bandwidth)
        summary["bandwidth"].push_back({{"threads", each.threads}, {"bytes_per_s", each.bytes_per_s}});
    for (const ScaleTarget& each : report.targets) {
        Summary entry{{"target", each.what}, {"value", each.value}, {"unit", each.unit}};
        if (each.asked) {
            entry["asked"] = *each.asked;
            entry["met"] = each.met();
        }
        summary["targets"].push_back(entry);
    }
    summary["energy"] = report.no_energy.empty() ? "measured" : report.no_energy;
    return summary;
}

void bench_scale(const BenchScaleOptions& options) {
    const ScaleReport report = measure(options);
    if (!options.out.empty()) draw_scale(report, options.out);
    if (options.json)
        print(summarise(report), true);
    else
        print_scale(report, std::cout);
}

// For other simulators: bench/peers reads what this writes.
void export_scale(const BenchScaleOptions& options) {
    const std::uint32_t elements = !options.elements.empty() ? options.elements.front()
                                   : options.quick           ? 200
                                                             : 10'000;
    const ScaleExport exported =
        export_population(elements, options.quick ? 200ms : 1000ms, options.export_to);
    Summary summary;
    summary["elements"] = elements;
    summary["events"] = exported.events;
    summary["dense_s"] = exported.dense_s;
    summary["sparse_s"] = exported.sparse_s;
    summary["folder"] = options.export_to;
    print(summary, options.json);
}

}  // namespace

Command bench_scale_command() {
    const auto options = std::make_shared<BenchScaleOptions>();
    return {
        .name = "scale",
        .help = "What a population costs, by its size, its activity and its form",
        .footer =
            "Checks first that all forms and threads give the same events.\n"
            "Writes scale.csv, scale_memory.csv, scale_bandwidth.csv, scale_targets.csv and pictures.\n"
            "Examples:\n  afferent bench scale --out out/scale\n"
            "  bench/peers/brian_population.py --afferent build/release/apps/afferent",
        .options =
            {
                option("--out", options->out, "Folder for the tables and the pictures"),
                option("--elements", options->elements, "How many elements; 9 to 1,000,000 if none"),
                option("--export", options->export_to,
                       "Measure nothing, and write one population with its drives and spikes into this "
                       "folder, for other simulators")
                    .excludes("--out"),
                flag("--quick", options->quick, "Fewer and smaller populations, in seconds"),
                flag("--json", options->json, "Print the results as JSON"),
            },
        .run = [options] { options->export_to.empty() ? bench_scale(*options) : export_scale(*options); },
    };
}

}  // namespace afferent
