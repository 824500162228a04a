// afferent convert: events from one file format to another.
#include <iostream>
#include <memory>
#include <string>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_file.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/scene/population.hpp"

namespace afferent {
namespace {

struct ConvertOptions {
    std::string from;
    std::string to;
    std::string scene;
    bool json = false;
};

// Event Stream and AEDAT 2 do not tell which afferents there are, nor does CSV by itself.
void take_population(const std::string& file, EventSet& set) {
    set.population = population_of(make_plan(Scene::from_file(file)));
    if (const Result<void> fits = check(set); !fits)
        throw Failure(file + ": these events are not of this scene: " + fits.error().text);
}

Summary summary_of(const ConvertOptions& options, const EventSet& set) {
    Summary summary{{"from", options.from}, {"to", options.to}, {"events", set.events.size()}};
    // Null if there are no events.
    Summary& first = summary["first_s"];
    if (!set.events.empty()) first = seconds(set.events.front().time);
    Summary& last = summary["last_s"];
    if (!set.events.empty()) last = seconds(set.events.back().time);
    summary["resolution_us"] = Seconds(set.resolution).count() * 1e6;
    summary["patches"] = Summary::List();
    for (const Population::Patch& patch : set.population.patches)
        summary["patches"].push_back(
            Summary{{"name", patch.name}, {"afferents", patch.afferents}, {"kind", patch.kind}});
    return summary;
}

void convert(const ConvertOptions& options) {
    // Refuses an unknown ending before anything is read.
    check_event_format(options.to);
    EventSet set = read_event_set(options.from);
    if (!options.scene.empty()) take_population(options.scene, set);
    write_event_file(options.to, set, options.from);
    if (options.json) return print(summary_of(options, set), true);
    std::cout << set.events.size() << " events\n";
}

}  // namespace

Command convert_command() {
    const auto options = std::make_shared<ConvertOptions>();
    return {
        .name = "convert",
        .help =
            "Convert events between .csv, Event Stream (.es), AEDAT 2 (.aedat), SONATA (.sonata.h5) and NWB "
            "(.nwb), or from a recording (.afferent)",
        .footer =
            "Example:\n  afferent convert out/grasp/events.csv grasp.nwb --scene examples/grasp.txtpb\n"
            "  afferent convert grasp.afferent grasp.sonata.h5\n\n"
            "What is known of the afferents, their patch, kind, place and elements, is in the columns of an "
            "NWB "
            "file; beside x.csv in x.afferents.csv (beside events.csv in afferents.csv), and beside "
            "x.sonata.h5 "
            "in x.nodes.h5 and x.node_types.csv. They are read from there, too.",
        .options =
            {
                positional("from", options->from, "The file to read").required(),
                positional("to", options->to, "The file to write; its ending says in which format")
                    .required(),
                option(
                    "--scene", options->scene,
                    "The scene that they are of, for the patch, kind and place of each afferent, silent or "
                    "not, where the file does not tell them"),
                flag("--json", options->json, "Print what was converted as JSON"),
            },
        .run = [options] { convert(*options); },
    };
}

}  // namespace afferent
