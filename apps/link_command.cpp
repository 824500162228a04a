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
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/status_service.hpp"

namespace afferent {
namespace {

struct Options {
    SceneOptions scene;
    bool watch = false;
    bool json = false;
};

// By side: "coprocessor", "channel", "hand".
Summary ask_all(const Scene& scene) {
    Summary all;
    for (const char* side : {"coprocessor", "channel", "hand"})
        if (auto status = ask_status(scene, side)) all[side] = *std::move(status);
    return all;
}

void show(const Summary& all) {
    for (const auto& [side, status] : all.entries()) {
        std::cout << side << '\n';
        print(status);
    }
}

double number(const Summary& status, const char* key) {
    const Summary* found = status.find(key);
    return found ? found->number().value_or(0) : 0;
}

std::string word(const Summary& status, const char* key) {
    const Summary* found = status.find(key);
    return found && found->text() ? *found->text() : "";
}

// Per second. A process that has restarted counts from 0 again.
double rate(const Summary& before, const Summary& now, const char* key, double elapsed_s) {
    const double from = number(before, key);
    return (number(now, key) - (from > number(now, key) ? 0 : from)) / elapsed_s;
}

void show_channel(const Summary& before, const Summary& now, double elapsed_s) {
    std::printf("%-12s", "channel");
    for (const auto& [way, words] :
         {std::pair("to_hand", "to the hand"), std::pair("to_coprocessor", "back")}) {
        static const Summary none;
        const Summary* const from = before.find(way);
        const Summary* const to = now.find(way);
        const Summary& counts = to ? *to : none;
        std::printf("  %s %6.0f frames/s  lost %.0f  dropped %.0f  changed %.0f", words,
                    rate(from ? *from : none, counts, "frames", elapsed_s), number(counts, "lost"),
                    number(counts, "dropped"), number(counts, "corrupted"));
    }
    std::puts("");
}

// One line: what has been sent and received since the line before.
void show_change(const std::string& side, const Summary& before, const Summary& now, double elapsed_s) {
    if (side == "channel") return show_channel(before, now, elapsed_s);
    if (!now.find("packets") || !before.find("packets"))
        return void(std::printf("%-12s %s\n", side.c_str(), word(now, "session").c_str()));
    const auto per_second = [&](const char* key) { return rate(before, now, key, elapsed_s); };
    std::printf("%-12s %8.2f s  %-10s %6.0f packets/s %8.0f events/s %8.2f kB/s", side.c_str(),
                number(now, "at_s"), word(now, "session").c_str(), per_second("packets"),
                per_second("events"), per_second("bytes") / 1e3);
    if (now.find("gain"))
        std::printf("  gaps %.0f  lost %.0f  %s  %5.2f N  gain %.2f", number(now, "gaps"),
                    number(now, "lost_events"), word(now, "grip_state").c_str(), number(now, "force_n"),
                    number(now, "gain"));
    else
        std::printf("  dropped %.0f", number(now, "dropped_packets"));
    std::puts("");
}

void watch(const Scene& scene, Summary before, bool json) {
    catch_interrupts();
    auto asked = std::chrono::steady_clock::now();
    while (!before.entries().empty()) {
        for (int i = 0; i < 20 && !interrupted(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        if (interrupted()) throw Interrupted();
        Summary now = ask_all(scene);
        const auto time = std::chrono::steady_clock::now();
        const std::chrono::duration<double> elapsed = time - asked;
        if (json) {
            std::cout << afferent::json(now) << '\n';
        } else {
            for (const auto& [side, status] : now.entries())
                if (const Summary* last = before.find(side))
                    show_change(side, *last, status, elapsed.count());
        }
        std::cout.flush();
        std::fflush(stdout);
        before = std::move(now);
        asked = time;
    }
}

void show_status(const Options& options) {
    const Scene scene = options.scene.read();
    const Summary all = ask_all(scene);
    if (all.entries().empty()) throw Failure("neither side of " + scene.name() + " runs on this machine");
    if (options.watch) return watch(scene, all, options.json);
    if (options.json)
        print(all, true);
    else
        show(all);
}

}  // namespace

Command link_command() {
    const auto options = std::make_shared<Options>();
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
