// afferent view: a scene or a recording in a browser, as it happens.
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/end_options.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/hand_command.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/replay_command.hpp"
#include "afferent/apps/run_scene.hpp"

namespace afferent {
namespace {

struct Options {
    SceneOptions scene;
    bool link = false;
    std::optional<double> speed;
    std::optional<double> from_s;
    ViewOptions view{.is_the_purpose = true};
};

bool is_recording(const std::string& file) { return file.ends_with(".afferent"); }

void view(const Options& options) {
    const std::string& file = options.scene.file;
    if (is_recording(file)) {
        if (options.link) throw Failure("--link: a recording has none; name a scene");
        if (options.scene.replaces())
            throw Failure(
                "--seed, --table, --emg, --duration, --set: a recording is shown as it was; name a scene");
        replay_recording({.file = file,
                          .out = {},
                          .speed = options.speed.value_or(1),
                          .from_s = options.from_s.value_or(0),
                          .view = options.view});
        return;
    }
    if (options.speed || options.from_s) throw Failure("--speed, --from-s: are for recordings (.afferent)");
    const Scene scene = options.scene.read();
    const bool has_chip = std::holds_alternative<scene::Chip>(scene.source);
    // A real hand is on a line, as is a chip, and both ends need a link.
    if (!options.link && !scene.hand.ability_hand && !has_chip) {
        const RunOptions run{
            .scene = options.scene, .out = {}, .record = {}, .realtime = true, .view = options.view};
        catch_interrupts();
        return run_scene(run, make_plan(run.scene.read_to_run()));
    }
    HandOptions hand;
    hand.scene = options.scene;
    hand.view = options.view;
    hand.view.is_the_purpose = false;
    hand.view.view = true;
    hand.with_chip = has_chip && !options.link;
    run_hand(hand);
}

}  // namespace

Command view_command() {
    const auto options = std::make_shared<Options>();
    std::vector<Option> more{
        flag("--link", options->link,
             "Be the hand of the scene's link, as afferent hand SCENE --view, in place of running both ends; "
             "that is what a hand on a serial line always is"),
        option("--speed", options->speed, "Of a recording: times the wall clock's pace").within(1e-3, 1e3),
        option("--from-s", options->from_s, "Of a recording: begin at this time of the scene").within(0, 1e9),
    };
    for (Option& each : options->view.list())
        if (each.name != "--view") more.push_back(std::move(each));
    std::vector<Option> all = options->scene.followed_by(std::move(more));
    all.front().help = "A scene, or a recording (.afferent) of what a hand received";
    return {
        .name = "view",
        .help = "Show a scene or a recording in a browser on this machine, as it happens",
        .footer =
            "Example:\n  afferent view examples/grasp.txtpb\n\n"
            "The page is served on 127.0.0.1 alone, at an address with a secret that is printed; it only "
            "shows.\nTo see it from another machine: docs/view.md. The commands run --realtime, hand, "
            "coprocessor and\nreplay have --view.",
        .options = std::move(all),
        .run = [options] { view(*options); },
    };
}

}  // namespace afferent
