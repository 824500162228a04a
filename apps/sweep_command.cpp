// afferent sweep: a scene with every combination of some of its fields' values, in one table.
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/studies/sweep.hpp"
#include "afferent/studies/sweep_report.hpp"

namespace afferent {
namespace {

struct SweepCommandOptions {
    SceneOptions scene;
    std::vector<std::string> over;
    std::uint64_t threads = 0;
    std::string out;
    bool json = false;
};

void sweep_scene(const SweepCommandOptions& options) {
    catch_interrupts();
    if (options.over.empty())
        throw Failure("sweep: --over PATH=VALUE,VALUE is missing: what is it to sweep over?");
    const Scene scene = options.scene.read();
    std::vector<SweepAxis> axes;
    for (const std::string& each : options.over) axes.push_back(SweepAxis::from(each));
    Results results(options.out, {"sweep.csv", "sweep.svg", "sweep.png", "sweep.json"});

    Progress progress("sweep of " + scene.file);
    const auto points = sweep(scene, axes, {.threads = options.threads, .progress = [&](double fraction) {
                                                progress.at(fraction);
                                                return !interrupted();
                                            }});
    const SweepTable table(axes, points);
    Summary summary{{"scene", scene.name}, {"interrupted", interrupted()}, {"points", table.rows()}};
    if (results.wanted()) {
        value_or_fail(table.write(results.file("sweep.csv")));
        const ScatterPicture picture = picture_of(scene, axes, points);
        if (!picture.series.empty()) tell_if_undrawn(draw(picture, results.file("sweep")));
        results.put_in_place(summary, "sweep.json");
    }
    if (options.json)
        print(summary, true);
    else
        table.print(std::cout);
    if (interrupted()) throw Interrupted();
}

}  // namespace

Command sweep_command() {
    const auto options = std::make_shared<SweepCommandOptions>();
    return {
        .name = "sweep",
        .help = "Run a scene with every combination of some of its fields' values, over the cores",
        .footer =
            "Prints a row for each combination. The same figures for any number of threads, but for "
            "run_time_s,\nwhich is measured beside the other runs.\n"
            "Examples:\n"
            "  afferent sweep examples/lossy.txtpb --over decoder=sliding_window,inversion,filter\n"
            "  afferent sweep examples/grasp.txtpb --set link=udp --over link.packet_ms=1,5,20 \\\n"
            "    --over neuron.delta_g=0,0.1,0.3 --out out/sweep",
        .options = options->scene.followed_by({
            option("--over", options->over,
                   "A field and the values that it takes: PATH=VALUE,VALUE,..., with paths and values as for "
                   "--set. Given several times: every combination, the last fastest"),
            option("--threads", options->threads, "Runs at a time; 0: as many as the machine has"),
            option("--out", options->out,
                   "Folder for sweep.csv, sweep.json, and sweep.svg and .png: error against bytes"),
            flag("--json", options->json, "Print the table as JSON"),
        }),
        .run = [options] { sweep_scene(*options); },
    };
}

}  // namespace afferent
