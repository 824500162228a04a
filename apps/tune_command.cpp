// afferent tune: makes the neurons of a scene meet their targets, and shows how well they do; with --gain,
// finds the gain that suits each condition of its trial.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <utility>
#include <vector>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/scene_file.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/apps/tune_gain.hpp"
#include "afferent/neurons/rate.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

struct TuneOptions {
    SceneOptions scene;
    std::string out;
    bool json = false;
    GainOptions gain;
};

// Multiples of the force at which the neuron meets its target.
constexpr double table_inputs[] = {0.015, 0.025, 0.05, 0.1, 0.15, 0.25, 0.4, 0.5, 0.75, 1, 1.25};

Summary tune_patch(const PatchPlan& patch) {
    const Tuned tuned = tune(patch.neuron, patch.target);
    const NeuronModel neuron = with_adaptation(patch.neuron, tuned.delta_g);
    const double share = patch.mean_share();
    const char* unit = patch.sustained() ? "n" : "n_per_s";
    Summary summary;
    summary["patch"] = patch.name;
    summary["mean_share"] = share;
    summary["rate"] = patch.target.rate == RateKind::steady ? "steady" : "onset";
    summary["rate_hz"] = patch.target.rate_hz;
    summary[std::string("grip_") + unit] = patch.target.input / share;
    summary[std::string("begins_at_grip_") + unit] = patch.target.begin_input / share;
    summary[gain_name(patch.encoder)] = tuned.gain;
    summary["bias_mv"] = tuned.bias_mv;
    summary["delta_g"] = tuned.delta_g;
    // Less than this is rounding.
    summary["residual_hz"] = std::abs(tuned.residual_hz) < 1e-9 ? 0 : tuned.residual_hz;
    for (const double multiple : table_inputs) {
        const double input = multiple * patch.target.input;
        const double drive = tuned.gain * input + tuned.bias_mv;
        summary["table"].push_back({{std::string("grip_") + unit, input / share},
                                    {"steady_hz", rate_hz(RateKind::steady, neuron, drive)},
                                    {"onset_hz", rate_hz(RateKind::onset, neuron, drive)}});
    }
    return summary;
}

std::string text_of(const Summary::List& table) {
    std::ostringstream text;
    text << std::fixed << std::setprecision(3) << std::right;
    for (const auto& [name, value] : table.front().entries()) text << std::setw(18) << name;
    text << '\n';
    for (const Summary& row : table) {
        for (const auto& [name, value] : row.entries()) text << std::setw(18) << *value.number();
        text << '\n';
    }
    return text.str();
}

// Patches with the same target have the same table, whatever their shares: it is printed once.
void print_patches(const Summary::List& patches) {
    std::vector<std::pair<std::string, std::string>> tables;  // and whose they are
    for (const Summary& patch : patches) {
        Summary values;
        for (const auto& [name, value] : patch.entries())
            if (value.list().empty()) values[name] = value;
        print(values);
        std::cout << '\n';
        const std::string& name = *patch.find("patch")->text();
        const std::string table = text_of(patch.find("table")->list());
        if (const auto same = std::ranges::find(tables, table, [](const auto& each) { return each.first; });
            same != tables.end())
            same->second += ", " + name;
        else
            tables.emplace_back(table, name);
    }
    for (const auto& [table, names] : tables)
        std::cout << "An afferent that feels the mean share of its patch (" << names << "):\n\n"
                  << table << '\n';
}

void tune_scene(const TuneOptions& options) {
    Scene scene = options.scene.read();
    const Plan plan = make_plan(scene);
    Summary::List patches;
    for (std::size_t i = 0; i < plan.patches.size(); ++i) {
        if (!is_tunable(plan.patches[i].encoder)) continue;
        patches.push_back(tune_patch(plan.patches[i]));
        const auto tuned = [&](const char* key) { return patches.back().find(key)->number().value(); };
        scene::Patch& written = scene.patches[i];
        written.neuron.delta_g = tuned("delta_g");
        if (auto* transient = std::get_if<scene::Transient>(&written.encoder)) {
            transient->gain_mv_s_per_n = tuned("gain_mv_s_per_n");
            transient->bias_mv = tuned("bias_mv");
        } else if (auto* sustained = std::get_if<scene::Sustained>(&written.encoder)) {
            sustained->gain_mv_per_n = tuned("gain_mv_per_n");
            sustained->bias_mv = tuned("bias_mv");
        }
    }
    if (!options.out.empty())
        write_scene(scene, "tuned by: afferent tune", options.out,
                    std::filesystem::path(options.out).parent_path());
    if (options.json) {
        Summary summary{{"scene", scene.name}};
        summary["written"] = options.out.empty() ? Summary() : Summary(options.out);
        summary["patches"] = patches;
        return print(summary, true);
    }
    print_patches(patches);
    if (options.out.empty())
        std::cout << "Nothing is written; --out FILE writes the tuned scene\n";
    else
        std::cout << "Written to " << options.out << '\n';
}

}  // namespace

Command tune_command() {
    const auto options = std::make_shared<TuneOptions>();
    return {
        .name = "tune",
        .help = "Make the neurons meet their tuning targets, or find the gain that suits a decoder",
        .footer =
            "Examples:\n"
            "  afferent tune examples/grasp.txtpb --out grasp.tuned.txtpb\n"
            "  afferent tune --gain examples/trial_in_hand.txtpb --conditions rate,filter --out out/gain",
        .options = options->scene.followed_by({
            option(
                "--out", options->out,
                "Write the tuned scene there; with --gain a folder, for scene, table and picture. If absent, "
                "nothing is written"),
            flag("--json", options->json, "Print the tables as JSON"),
            flag("--gain", options->gain.wanted,
                 "Search onset, lambda, bound and lead of the gain in the scene's trial: as few delicate "
                 "objects "
                 "broken as can be, and few heavy ones dropped"),
            option("--conditions", options->gain.conditions,
                   "With --gain: what the gain goes by, separated by commas")
                .needs("--gain")
                .show_default(),
            option("--presentations", options->gain.presentations,
                   "With --gain: of each gain that is compared in the end")
                .needs("--gain")
                .within(1, 4294967295)
                .show_default(),
            option("--dropped", options->gain.most_dropped_pct,
                   "With --gain: at most so many heavy objects dropped, in %")
                .needs("--gain")
                .within(0, 100)
                .show_default(),
            option("--held-out-seed", options->gain.held_out_seed,
                   "With --gain: of the objects that no gain is chosen on; if absent, the one after the "
                   "scene's")
                .needs("--gain"),
        }),
        .run =
            [options] {
                if (!options->gain.wanted) return tune_scene(*options);
                tune_gain(options->scene.read(), options->gain, options->out, options->json);
            },
    };
}

}  // namespace afferent
