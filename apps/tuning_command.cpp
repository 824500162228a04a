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
#include "afferent/io/files/results_folder.hpp"
#include "afferent/studies/tuning_report.hpp"

namespace afferent {
namespace {

struct TuningCommand {
    SceneOptions scene;
    std::uint64_t address = 0;
    TuningOptions options;
    std::string out;
    bool json = false;
};

void show_tuning(const TuningCommand& given) {
    TuningOptions options = given.options;
    // No scene has as many as that.
    const auto address =
        static_cast<Address>(std::min<std::uint64_t>(given.address, std::numeric_limits<Address>::max()));
    Progress progress("probing");
    options.progress = [&](double fraction) { progress.at(fraction); };
    const AfferentTuning tuning = value_or_fail(tuning_of(make_plan(given.scene.read()), address, options));
    const Summary summary = summary_of(tuning);
    if (!given.out.empty()) {
        ResultsFolder results =
            value_or_fail(ResultsFolder::create(given.out, {"tuning.svg", "tuning.png", "summary.json"}));
        tell_if_undrawn(draw(tuning_picture(tuning), results.unfinished() / "tuning"));
        write(summary, results.unfinished() / "summary.json");
        value_or_fail(results.put_in_place());
    }
    if (given.json) return print(summary, true);
    print(tuning, std::cout);
    if (!given.out.empty()) std::cout << "\nWritten to " << given.out << '\n';
}

}  // namespace

Command tuning_command() {
    const auto given = std::make_shared<TuningCommand>();
    return {
        .name = "tuning",
        .help = "Show what makes one afferent fire: its field, tuning curve, rate by depth and intervals",
        .footer =
            "A flat probe presses and vibrates at the afferent's place, on patches with an outline.\n"
            "Example:\n  afferent tuning examples/fingertip.txtpb --address 40 --out out/tuning",
        .options = given->scene.followed_by({
            option("--address", given->address, "The afferent").required(),
            option("--radius-mm", given->options.radius_mm, "Radius of the probe").show_default().positive(),
            option("--hold-mm", given->options.hold_mm, "Depth at which intervals are counted")
                .show_default()
                .positive(),
            option("--samples-hz", given->options.rate_hz, "Samples a second; by default the scene's")
                .positive(),
            option("--out", given->out, "Folder for tuning.svg, tuning.png and summary.json"),
            flag("--json", given->json, "Print all numbers as JSON"),
        }),
        .run = [given] { show_tuning(*given); },
    };
}

}  // namespace afferent
