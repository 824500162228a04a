// afferent convert: events from one file format to another.
#include <iostream>
#include <memory>
#include <string>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_file.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

struct ConvertOptions {
    std::string from;
    std::string to;
    std::string scene;
    bool json = false;
};

// CSV, Event Stream and AEDAT 2 do not tell which afferents there are.
void name_patches(const std::string& file, EventSet& set) {
    set.patches.clear();
    for (const PatchPlan& patch : make_plan(Scene::from_file(file)).patches)
        set.patches.push_back({patch.name, patch.afferents()});
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
    for (const EventSet::Patch& patch : set.patches)
        summary["patches"].push_back(Summary{{"name", patch.name}, {"afferents", patch.afferents}});
    return summary;
}

void convert(const ConvertOptions& options) {
    // Refuses an unknown ending before anything is read.
    check_event_format(options.to);
    EventSet set = read_event_file(options.from);
    if (!options.scene.empty()) name_patches(options.scene, set);
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
            "  afferent convert grasp.afferent grasp.sonata.h5",
        .options =
            {
                positional("from", options->from, "The file to read").required(),
                positional("to", options->to, "The file to write; its ending says in which format")
                    .required(),
                option("--scene", options->scene,
                       "The scene that they are of, for the names of its patches and its silent afferents, "
                       "where the file does not tell them"),
                flag("--json", options->json, "Print what was converted as JSON"),
            },
        .run = [options] { convert(*options); },
    };
}

}  // namespace afferent
