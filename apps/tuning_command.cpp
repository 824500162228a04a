// afferent tuning: what makes one afferent of a scene fire.
#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/studies/tuning_report.hpp"

namespace afferent {
namespace {

struct TuningCommand {
    SceneOptions scene;
    std::optional<std::uint64_t> address;
    std::string patch;
    TuningOptions options;
    std::string out;
    bool json = false;
};

template <class Tuning>
void tell(const TuningCommand& given, const Tuning& tuning, Results& results) {
    const Summary summary = summary_of(tuning);
    if (results.wanted()) results.put_in_place(summary, "summary.json");
    if (given.json) return print(summary, true);
    print(tuning, std::cout);
    if (results.wanted()) std::cout << "\nWritten to " << given.out << '\n';
}

void show_afferent(const TuningCommand& given, const Plan& plan, const TuningOptions& options) {
    // No scene has as many as that.
    const auto address =
        static_cast<Address>(std::min<std::uint64_t>(*given.address, std::numeric_limits<Address>::max()));
    const AfferentTuning tuning = value_or_fail(tuning_of(plan, address, options));
    Results results(given.out, {"tuning.svg", "tuning.png", "summary.json"});
    if (results.wanted()) tell_if_undrawn(draw(tuning_picture(tuning), results.file("tuning")));
    tell(given, tuning, results);
}

void show_patch(const TuningCommand& given, const Plan& plan, const TuningOptions& options) {
    const auto patch = value_or_fail(tuning_of_patch(plan, given.patch, options));
    Results results(given.out, {"map.csv", "map.svg", "map.png", "summary.json"});
    if (results.wanted()) {
        value_or_fail(write_map(patch, results.file("map.csv")));
        tell_if_undrawn(draw(tuning_maps(patch), results.file("map")));
    }
    tell(given, patch, results);
}

void show_tuning(const TuningCommand& given) {
    if (!given.address && given.patch.empty())
        throw Failure("which afferent? Give its --address, or a --patch for all of one");
    TuningOptions options = given.options;
    Progress progress("probing");
    options.progress = [&](double fraction) { progress.at(fraction); };
    const Plan plan = make_plan(given.scene.read());
    if (given.address)
        show_afferent(given, plan, options);
    else
        show_patch(given, plan, options);
}

}  // namespace

Command tuning_command() {
    const auto given = std::make_shared<TuningCommand>();
    return {
        .name = "tuning",
        .help =
            "Show what makes afferents fire: field, tuning curve, rate by depth and intervals, as maps of a "
            "patch",
        .footer =
            "A flat probe presses and vibrates at the afferent's place, on patches with an outline.\n"
            "Examples:\n  afferent tuning examples/fingertip.txtpb --address 40 --out out/tuning\n"
            "  afferent tuning examples/fingertip.txtpb --patch RA --out out/map",
        .options = given->scene.followed_by({
            option("--address", given->address, "The afferent"),
            option("--patch", given->patch, "Maps of all afferents of a patch, half a second for each")
                .excludes("--address"),
            option("--radius-mm", given->options.radius_mm, "Radius of the probe").show_default().positive(),
            option("--hold-mm", given->options.hold_mm, "Depth at which intervals are counted")
                .show_default()
                .positive(),
            option("--samples-hz", given->options.rate_hz, "Samples a second; by default the scene's")
                .positive(),
            option("--out", given->out, "Folder for a picture, a patch's map.csv, and summary.json"),
            flag("--json", given->json, "Print all numbers as JSON"),
        }),
        .run = [given] { show_tuning(*given); },
    };
}

}  // namespace afferent
