// afferent bench decoding: the error of the force against bytes per second, and where sensors, shares or
// neurons are not as the decoder is told.
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "afferent/apps/bench_commands.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/summary.hpp"
#include "bench/closed_loop.hpp"
#include "bench/decoding_bench.hpp"
#include "bench/decoding_cost.hpp"
#include "bench/decoding_judge.hpp"
#include "bench/decoding_loss.hpp"
#include "bench/decoding_tables.hpp"
#include "bench/robust_tables.hpp"
#include "bench/scheme_map.hpp"

namespace afferent {
namespace {

struct BenchDecodingOptions {
    TouchOptions touches;
    std::string out;
    bool json = false;
    bool not_as_told = false;  // nothing else; the touches' scenes are names of cases
    std::vector<std::string> decoders;
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
        if (row.cell.dead_band) entry["dead_band"] = *row.cell.dead_band;
        if (row.cell.tolerance)
            entry["tolerance_us"] = static_cast<double>(row.cell.tolerance->count()) / 1e3;
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

std::vector<Judgement> judge(const std::vector<Touch>& touched, bool quick) {
    Progress progress("particle filter");
    return judge_filter(touched, quick ? 1 : 3, [&](double fraction) { progress.at(fraction); });
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

std::vector<RobustRow> robustness(const TouchOptions& touches, const RobustOptions& options) {
    Progress progress("not as told");
    return measure_robustness(robust_input(touches.examples, touches.data), options,
                              [&](double fraction) { progress.at(fraction); });
}

void write(const std::vector<RobustRow>& rows, const std::string& folder) {
    if (folder.empty() || rows.empty()) return;
    write_robustness(rows, folder);
    draw_robustness(rows, folder);
}

void summarise(const std::vector<RobustRow>& rows, Summary& summary) {
    for (const RobustRow& row : rows) {
        Summary entry;
        entry["case"] = row.what->name;
        entry["scene"] = row.scene;
        entry["decoder"] = row.decoder;
        entry["stated"] = row.stated;
        entry["rms_n"] = row.score.rms_n;
        entry["bias_n"] = row.score.bias_n;
        if (row.decoder != read_by_sensors) {
            entry["coverage_95"] = row.score.coverage_95;
            entry["above_2_sigma"] = row.score.above_2_sigma;
            entry["left_out"] = row.score.left_out;
            entry["saturated"] = row.score.saturated;
            entry["doubtful"] = row.score.doubtful;
        }
        summary["not_as_told"].push_back(entry);
    }
}

// The positional names are those of cases.
void bench_not_as_told(const BenchDecodingOptions& options) {
    const std::vector<std::string>& cases = options.touches.scenes;
    const std::vector<RobustRow> rows =
        robustness(options.touches, {cases, options.decoders, options.touches.quick});
    write(rows, options.out);
    if (options.json) {
        Summary summary;
        summarise(rows, summary);
        print(summary, true);
    } else if (cases.empty()) {
        print_robust_cases(rows, std::cout);
    } else {
        print_robust_rows(rows, std::cout);
    }
}

// The hands are drawn at random, so that they belong to the benchmark's own scenes only.
std::vector<ClosedLoopRow> closed_loops(const TouchOptions& options) {
    if (!options.scenes.empty()) return {};
    constexpr std::uint64_t quick_loops = 100;
    constexpr std::uint64_t all_loops = 1000;
    Progress progress("closed loops");
    return search_closed_loops(1, options.quick ? quick_loops : all_loops,
                               [&](double fraction) { progress.at(fraction); });
}

void bench_decoding(const BenchDecodingOptions& options) {
    if (options.not_as_told) return bench_not_as_told(options);
    if (!options.decoders.empty()) throw std::runtime_error("--decoder needs --not-as-told");
    const std::vector<Touch> touched = touches(options.touches);
    const std::vector<DecodingRow> rows = measure(touched, options.touches.quick);
    if (!options.out.empty()) {
        write_decoding(rows, options.out);
        draw_decoding(rows, options.out);
    }
    const std::vector<Judgement> judgements = judge(touched, options.touches.quick);
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
    std::vector<RobustRow> robust;
    if (options.touches.scenes.empty())
        robust = robustness(options.touches, {.quick = options.touches.quick});
    write(robust, options.out);
    const std::vector<ClosedLoopRow> loops = closed_loops(options.touches);
    if (!options.out.empty() && !loops.empty()) write_closed_loops(loops, options.out);
    if (options.json) {
        Summary summary = summarise(rows);
        summarise(robust, summary);
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
        for (const auto& [loop, result] : loops)
            summary["closed_loops"].push_back({{"decoder", result.decoder},
                                               {"wrong", loop.wrong},
                                               {"accepted", loop.refusal.empty()},
                                               {"limit_n", result.limit_n},
                                               {"full_scale_n", result.full_scale_n},
                                               {"momentum_n", result.momentum_n},
                                               {"peak_n", result.peak_n},
                                               {"above_s", result.above_s}});
        print(summary, true);
        return;
    }
    print_decoding(rows, std::cout);
    print_judgements(judgements, std::cout);
    print_loss(losses, std::cout);
    if (!costs.empty()) print_cost(costs, std::cout);
    if (!map.empty()) print_map(map, std::cout);
    if (!robust.empty()) print_robust_cases(robust, std::cout);
    if (!loops.empty()) print_closed_loops(loops, std::cout);
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
            "scheme with the fewest bytes by elements, activity and delay, with its picture; robust.csv: the "
            "error\nwhere the sensors and neurons are not as the decoder is told; and closed_loop.csv: "
            "random hands, "
            "and\nwhether the gain keeps their forces at the limit.\n"
            "Examples:\n  afferent bench decoding --out out/decoding\n"
            "  afferent bench decoding --not-as-told gains full_scale --decoder filter",
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
                flag("--not-as-told", options->not_as_told,
                     "Only where sensors and neurons are not as the decoder is told. SCENE is then a case, "
                     "or how the names of some begin; none: a table of all, in Markdown"),
                option("--decoder", options->decoders, "With --not-as-told: these decoders alone"),
                flag("--quick", options->touches.quick, "The grasp and the paper's neuron, in seconds"),
                flag("--json", options->json, "Print the results as JSON"),
            },
        .run = [options] { bench_decoding(*options); },
    };
}

}  // namespace afferent
