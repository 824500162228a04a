// afferent link: how a session on this machine stands.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <thread>
#include <utility>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/link_status.hpp"
#include "afferent/apps/scene_options.hpp"

namespace afferent {
namespace {

struct LinkStatusOptions {
    SceneOptions scene;
    bool watch = false;
    bool json = false;
};

void watch(const Scene& scene, Summary before, bool json) {
    catch_interrupts();
    auto asked = std::chrono::steady_clock::now();
    while (!before.entries().empty()) {
        for (int i = 0; i < 20 && !interrupted(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        if (interrupted()) throw Interrupted();
        Summary now = ask_ends(scene);
        const auto time = std::chrono::steady_clock::now();
        const std::chrono::duration<double> elapsed = time - asked;
        if (json)
            std::cout << afferent::json(now) << '\n';
        else
            show_changes(before, now, elapsed.count());
        std::cout.flush();
        std::fflush(stdout);
        before = std::move(now);
        asked = time;
    }
}

void show_status(const LinkStatusOptions& options) {
    const Scene scene = options.scene.read();
    const Summary all = ask_ends(scene);
    if (all.entries().empty()) throw Failure("neither end of " + scene.file + " runs on this machine");
    if (options.watch) return watch(scene, all, options.json);
    if (options.json)
        print(all, true);
    else
        show_ends(all);
}

}  // namespace

Command link_command() {
    const auto options = std::make_shared<LinkStatusOptions>();
    Command status{
        .name = "status",
        .help =
            "What the coprocessor and the hand of a scene, and the channel between them, have sent, got and "
            "lost so far",
        .footer = "Example:\n  afferent link status examples/grasp.txtpb",
        .options = options->scene.followed_by({
            flag("--watch", options->watch, "A line each second, until all have ended"),
            flag("--json", options->json, "As JSON; with --watch one object a line"),
        }),
        .run = [options] { show_status(*options); },
    };
    return {
        .name = "link",
        .help = "How a session on this machine stands",
        .footer = "Example:\n  afferent link status examples/grasp.txtpb --watch",
        .commands = {std::move(status)},
    };
}

}  // namespace afferent
