// afferent bench decoding: what does a byte buy?
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "afferent/apps/bench_commands.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/decoding_bench.hpp"
#include "bench/decoding_cost.hpp"
#include "bench/decoding_judge.hpp"
#include "bench/decoding_loss.hpp"
#include "bench/decoding_tables.hpp"
#include "bench/scheme_map.hpp"

namespace afferent {
namespace {

struct BenchDecodingOptions {
    TouchOptions touches;
    std::string out;
    bool json = false;
};

Summary summarise(const std::vector<DecodingRow>& rows) {
    Summary summary;
    for (const DecodingRow& row : rows) {
        Summary entry;
        entry["scene"] = row.touch->name;
        entry["elements"] = row.touch->elements();
        entry["scheme"] = row.cell.scheme;
        entry["decoder"] = row.cell.decoder;
        if (row.cell.tick) entry["tick_us"] = static_cast<double>(row.cell.tick->count()) / 1e3;
        entry["deadline_ms"] = Milliseconds(row.cell.deadline).count();
        if (!row.cell.tick)
            entry["sample_ms"] =
                Milliseconds(row.cell.every_scan * row.touch->activity.frame_interval).count();
        if (row.cell.delta) entry["delta"] = *row.cell.delta;
        entry["bytes_per_s"] = row.bytes_per_s;
        entry["rms_n"] = row.score.rms_n;
        entry["rms_sensed_n"] = row.score.rms_sensed_n;
        entry["p95_n"] = row.score.p95_n;
        entry["hold_bias_n"] = row.score.hold_bias_n;
        entry["overshoot_n"] = row.score.overshoot_n;
        entry["delay_ms"] = row.score.delay_ms;
        if (row.score.coverage_95) entry["coverage_95"] = *row.score.coverage_95;
        entry["times_the_limit"] = row.times_the_limit;
        summary["decoding"].push_back(entry);
    }
    return summary;
}

std::vector<DecodingRow> measure(const std::vector<Touch>& touched, bool quick) {
    Progress progress("bench decoding");
    return measure_decoding(touched, quick, [&](double fraction) { progress.at(fraction); });
}

std::vector<Judgement> judge(const std::vector<Touch>& touched) {
    Progress progress("particle filter");
    return judge_filter(touched, [&](double fraction) { progress.at(fraction); });
}

std::vector<LossRow> lose(const std::vector<Touch>& touched) {
    Progress progress("lost packets");
    return measure_loss(touched, [&](double fraction) { progress.at(fraction); });
}

// With the benchmark's own scenes.
std::vector<CostRow> cost_of(const TouchOptions& options) {
    if (!options.scenes.empty()) return {};
    Progress progress("cost");
    return measure_cost(Scene::from_file(options.examples / "grasp.txtpb"), options.quick,
                        [&](double fraction) { progress.at(fraction); });
}

std::vector<MapCell> map_of(const TouchOptions& options) {
    if (!options.scenes.empty()) return {};
    Progress progress("map");
    return map_schemes(Scene::from_file(options.examples / "grasp.txtpb"), options.quick,
                       [&](double fraction) { progress.at(fraction); });
}

void bench_decoding(const BenchDecodingOptions& options) {
    const std::vector<Touch> touched = touches(options.touches);
    const std::vector<DecodingRow> rows = measure(touched, options.touches.quick);
    if (!options.out.empty()) {
        write_decoding(rows, options.out);
        draw_decoding(rows, options.out);
    }
    const std::vector<Judgement> judgements = judge(touched);
    if (!options.out.empty()) write_judgements(judgements, options.out);
    const std::vector<LossRow> losses = lose(touched);
    if (!options.out.empty()) write_loss(losses, options.out);
    const std::vector<CostRow> costs = cost_of(options.touches);
    if (!options.out.empty() && !costs.empty()) write_cost(costs, options.out);
    const std::vector<MapCell> map = map_of(options.touches);
    if (!options.out.empty() && !map.empty()) {
        write_map(map, options.out);
        draw_map(map, 0.2, options.out);
    }
    if (options.json) {
        Summary summary = summarise(rows);
        for (const Judgement& row : judgements)
            summary["judge"].push_back({{"scene", row.scene},
                                        {"elements", row.elements},
                                        {"filter_rms_sensed_n", row.filter_rms_n},
                                        {"particles_rms_sensed_n", row.particles_rms_n}});
        for (const LossRow& row : losses)
            summary["loss"].push_back({{"scene", row.scene},
                                       {"elements", row.elements},
                                       {"decoder", row.decoder},
                                       {"lost_pct", 100 * lost_part_of_packets},
                                       {"lossless_rms_n", row.lossless_rms_n},
                                       {"rms_n", row.rms_n},
                                       {"lossless_coverage_95", row.lossless_coverage_95},
                                       {"coverage_95", row.coverage_95}});
        for (const CostRow& row : costs)
            summary["cost"].push_back({{"afferents", row.afferents},
                                       {"decoder", row.decoder},
                                       {"events_per_s", row.events_per_s},
                                       {"ns_per_event", row.ns_per_event},
                                       {"least_ns", row.least_ns},
                                       {"most_ns", row.most_ns},
                                       {"ns_per_estimate", row.ns_per_estimate},
                                       {"core", row.core()}});
        print(summary, true);
        return;
    }
    print_decoding(rows, std::cout);
    print_judgements(judgements, std::cout);
    print_loss(losses, std::cout);
    if (!costs.empty()) print_cost(costs, std::cout);
    if (!map.empty()) print_map(map, std::cout);
}

}  // namespace

Command bench_decoding_command() {
    const auto options = std::make_shared<BenchDecodingOptions>();
    return {
        .name = "decoding",
        .help = "What a byte buys: the error of the force against bytes per second",
        .footer =
            "Writes decoding.csv with a picture for each scene, judge.csv (the filter against a particle "
            "filter),\nloss.csv (with lost packets), cost.csv (what an event takes to decode), and "
            "map.csv:\nthe "
            "scheme with the fewest bytes by elements, activity and delay, with its picture.\n"
            "Example:\n  afferent bench decoding --out out/decoding",
        .options =
            {
                positional("SCENE", options->touches.scenes,
                           "Scene files; if none: the grasp, the paper's neuron, recorded tables, and 1,000 "
                           "elements of which a tenth is touched"),
                option("--out", options->out, "Folder for the tables and the pictures"),
                option("--examples", options->touches.examples, "Folder of the example scenes")
                    .show_default(),
                option("--data", options->touches.data, "Folder of recorded forces, in tables of newtons")
                    .show_default(),
                flag("--quick", options->touches.quick, "The grasp and the paper's neuron, in seconds"),
                flag("--json", options->json, "Print the results as JSON"),
            },
        .run = [options] { bench_decoding(*options); },
    };
}

}  // namespace afferent
