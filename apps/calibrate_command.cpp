// afferent calibrate: fits a scene to recorded forces, and to the spikes recorded beside them.
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_file.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_file.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/scene/scene_table.hpp"
#include "afferent/studies/calibrate_report.hpp"

namespace afferent {
namespace {

struct CalibrateOptions {
    SceneOptions scene;
    std::string from;
    std::string events;
    std::string out;
    bool json = false;
};

void write_results(const SceneFit& fit, const Summary& summary, const std::string& folder) {
    ResultsFolder results = value_or_fail(ResultsFolder::create(
        folder, {"scene.txtpb", "drive.svg", "drive.png", "motion.svg", "motion.png", "summary.json"}));
    write_scene(fit.scene, "fitted by: afferent calibrate", results.unfinished() / "scene.txtpb", folder);
    if (!fit.patches.empty()) tell_if_undrawn(draw(drive_picture(fit), results.unfinished() / "drive"));
    if (fit.motions) tell_if_undrawn(draw(motion_picture(*fit.motions), results.unfinished() / "motion"));
    write(summary, results.unfinished() / "summary.json");
    value_or_fail(results.put_in_place());
}

void calibrate_scene(const CalibrateOptions& options) {
    const Scene scene = options.scene.read();
    scene::Table from{.path = options.from};
    // The scene says how its own table is read.
    std::error_code failure;
    const scene::Table* const own = force_table(scene.source);
    if (own && std::filesystem::equivalent(scene.resolve(own->path), options.from, failure)) from = *own;
    options.scene.of_table.apply(from);
    auto read = read_table(options.from, table_options(from));
    if (const auto* error = std::get_if<TableError>(&read)) throw Failure(error->message());
    EventSet events;
    if (!options.events.empty()) events = read_event_set(options.events);
    const SceneFit fit = value_or_fail(calibrate(scene, std::get<Table>(read), events.events, from.unit));
    const Summary summary = summary_of(fit);
    if (!options.out.empty()) write_results(fit, summary, options.out);
    if (options.json) return print(summary, true);
    print(fit, std::cout);
    if (options.out.empty())
        std::cout << "Nothing is written; --out DIR writes the fitted scene, its picture and summary.json\n";
    else
        std::cout << "Written to " << options.out << '\n';
}

}  // namespace

Command calibrate_command() {
    const auto options = std::make_shared<CalibrateOptions>();
    options->scene.choice_is_of_scene = false;
    return {
        .name = "calibrate",
        .help = "Fit gains, biases, shares and the filter's noise to recorded forces and spikes",
        .footer =
            "Example:\n  afferent calibrate examples/recorded.txtpb --from examples/data/grip.csv --out "
            "out/fitted",
        .options = options->scene.followed_by({
            option("--from", options->from,
                   "A table of forces: the grip force in newtons, or a column for each element, in newtons, "
                   "counts or volts")
                .required(),
            option("--events", options->events,
                   "The spikes recorded beside it: a recording, or what afferent convert writes"),
            option("--out", options->out, "Folder for scene.txtpb, its pictures and summary.json"),
            flag("--json", options->json, "Print the fit as JSON"),
        }),
        .run = [options] { calibrate_scene(*options); },
    };
}

}  // namespace afferent
