#include "afferent/apps/tune_gain.hpp"

#include <iostream>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/listed.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_file.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/studies/trial/gain_report.hpp"
#include "afferent/studies/trial/gain_search.hpp"

namespace afferent {
namespace {

std::uint64_t held_out_seed(const Scene& scene, const GainOptions& options) {
    if (options.held_out_seed < 0) return scene.seed + 1;
    const auto seed = static_cast<std::uint64_t>(options.held_out_seed);
    if (seed == scene.seed)
        throw Failure("--held-out-seed: must not be the scene's own, on which the gains are chosen");
    return seed;
}

std::vector<std::string> conditions_of(const GainOptions& options) {
    std::vector<std::string> conditions = listed("--conditions", options.conditions);
    if (conditions.empty()) throw Failure("--conditions: names none");
    return conditions;
}

}  // namespace

void tune_gain(const Scene& scene, const GainOptions& options, const std::string& out, bool json) {
    catch_interrupts();
    Progress progress("tune --gain");
    const GainSearch search{.conditions = conditions_of(options),
                            .presentations = static_cast<std::uint32_t>(options.presentations),
                            .held_out_seed = held_out_seed(scene, options),
                            .most_dropped = options.most_dropped_pct / 100,
                            .progress = [&](double share) {
                                progress.at(share);
                                return !interrupted();
                            }};
    Results results(out, {"gain.csv", "gain.svg", "gain.png", "scene.txtpb", "gain.json"});
    const std::vector<GainFront> fronts = search_gains(scene, search);
    Summary summary{{"scene", scene.name},
                    {"seed", scene.seed},
                    {"held_out_seed", search.held_out_seed},
                    {"presentations", search.presentations},
                    {"most_dropped_pct", options.most_dropped_pct},
                    {"interrupted", interrupted()}};
    append(summary, summary_of(fronts));
    if (results.wanted()) {
        value_or_fail(write_gains(fronts, results.file("gain.csv")));
        if (!fronts.empty()) tell_if_undrawn(draw_gains(fronts, search.most_dropped, results.file("gain")));
        write_scene(with_chosen_gains(scene, fronts), "with the gains of: afferent tune --gain",
                    results.file("scene.txtpb"), out);
        results.put_in_place(summary, "gain.json");
    }
    if (json)
        print(summary, true);
    else {
        print_gains(fronts, std::cout);
        std::cout << '\n'
                  << (out.empty() ? "Nothing is written; --out DIR writes table, picture and scene"
                                  : "Written to " + out)
                  << '\n';
    }
    if (interrupted()) throw Interrupted();
}

}  // namespace afferent
