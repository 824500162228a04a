// afferent bench bandwidth: what must a link carry?
#include <filesystem>
#include <memory>
#include <string>

#include "afferent/apps/bench_commands.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/bandwidth_bench.hpp"
#include "bench/bandwidth_tables.hpp"

namespace afferent {
namespace {

struct BenchBandwidthOptions {
    BandwidthScenes scenes{
        .scene = "examples/grasp.txtpb", .force_tables = {}, .elements = {9, 1000, 100'000}};
    std::string out;
    bool quick = false;
    bool json = false;
};

Summary summarise(const Bandwidth& bandwidth) {
    Summary summary;
    for (const BandwidthRow& row : bandwidth.rows) {
        Summary entry;
        entry["elements"] = row.activity->elements;
        entry["activity"] = row.activity->name;
        entry["scheme"] = row.result.scheme;
        if (row.result.tick) entry["tick_us"] = static_cast<double>(row.result.tick->count()) / 1e3;
        if (row.result.deadline) entry["deadline_ms"] = Milliseconds(*row.result.deadline).count();
        if (row.result.delta_n) entry["delta_n"] = *row.result.delta_n;
        if (row.result.dead_band) entry["dead_band"] = *row.result.dead_band;
        entry["events"] = row.activity->events.size();
        entry["bytes_per_s"] = row.bytes_per_s();
        if (row.result.poisson_ratio) entry["poisson_ratio"] = *row.result.poisson_ratio;
        if (row.result.causal_bits) {
            entry["causal_bits_per_event"] = *row.result.causal_bits;
            entry["poisson_bits_per_event"] = *row.result.poisson_bits;
        }
        if (row.result.rms_n) entry["rms_n"] = *row.result.rms_n;
        if (row.result.encode_ns) entry["encode_ns"] = *row.result.encode_ns;
        if (row.result.decode_ns) entry["decode_ns"] = *row.result.decode_ns;
        summary["bandwidth"].push_back(entry);
    }
    for (const TransportResult& row : bandwidth.transports)
        summary["transport"].push_back({{"transport", row.transport},
                                        {"packet_ms", Milliseconds(row.packet).count()},
                                        {"events_per_s", row.events_per_s},
                                        {"p50_us", row.p50_us},
                                        {"p99_us", row.p99_us}});
    return summary;
}

Bandwidth measure(const std::vector<LinkActivity>& activities) {
    Progress progress("bench bandwidth");
    return measure_bandwidth(activities, [&](double fraction) { progress.at(fraction); });
}

void bench_bandwidth(const BenchBandwidthOptions& options) {
    if (!options.out.empty()) std::filesystem::create_directories(options.out);
    const std::vector<LinkActivity> activities = link_activities(options.scenes);
    const Bandwidth bandwidth = measure(activities);
    if (!options.out.empty()) {
        write_bandwidth(bandwidth, options.out);
        draw_bandwidth(bandwidth, options.out);
    }
    if (options.json)
        print(summarise(bandwidth), true);
    else
        print_bandwidth(bandwidth);
}

}  // namespace

Command bench_bandwidth_command() {
    const auto options = std::make_shared<BenchBandwidthOptions>();
    return {
        .name = "bandwidth",
        .help = "What a link must carry, for events and every alternative",
        .footer = "Example:\n  afferent bench bandwidth examples/grasp.txtpb --out out/bandwidth",
        .options =
            {
                positional("scene", options->scenes.scene,
                           "Scene whose sensors, neurons and grasp are measured")
                    .show_default(),
                option("--out", options->out,
                       "Folder for bandwidth.csv, transport.csv, bandwidth.svg and .png"),
                option("--table", options->scenes.force_tables,
                       "Recorded grip forces in newtons, measured as further activities"),
                option("--elements", options->scenes.elements, "How many elements").show_default(),
                flag("--quick", options->quick, "Nine elements alone"),
                flag("--json", options->json, "Print the results as JSON"),
            },
        .run =
            [options] {
                if (options->quick) options->scenes.elements = {9};
                bench_bandwidth(*options);
            },
    };
}

}  // namespace afferent
