// afferent channel: an imperfect channel between a coprocessor and a hand, as a process of its own.
#include <iostream>
#include <memory>
#include <optional>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/io/links/relay.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/relay_parameters.hpp"

namespace afferent {
namespace {

struct ChannelOptions {
    SceneOptions scene;
    bool both_ways = false;
    bool json = false;
};

Summary summarise(const RelayCounts& counts) {
    const auto way = [](const ChannelCounts& of) {
        Summary summary;
        summary["frames"] = of.sent;
        summary["arrived"] = of.arrived;
        summary["lost"] = of.lost;
        summary["dropped"] = of.dropped;
        summary["duplicated"] = of.duplicated;
        summary["corrupted"] = of.corrupted;
        summary["reordered"] = of.reordered;
        return summary;
    };
    Summary summary;
    summary["connections"] = counts.connections;
    summary["to_hand"] = way(counts.to_hand);
    summary["to_coprocessor"] = way(counts.to_coprocessor);
    return summary;
}

void run_channel(const ChannelOptions& options) {
    catch_interrupts();
    const Scene scene = options.scene.read();
    if (!scene.link.channel)
        throw Failure(scene.file +
                      ": the link has no channel; give it one, as in link { channel { loss: 0.01 } }");
    const LinkAddress hand = value_or_fail(hand_address(scene, LinkEnd::coprocessor));
    const Plan plan = make_plan(scene);
    EventLoop loop;
    const auto relay =
        value_or_fail(Relay::open(loop.io(), channel_address(hand), hand,
                                  value_or_fail(relay_parameters(plan, hand, options.both_ways))));
    const StatusService service(loop.io(), scene, "channel", [&] { return summarise(relay->counts()); });
    std::cerr << "from " << text(relay->address()) << " to " << text(hand) << ", until Ctrl-C\n";
    loop.run([]() -> std::optional<EventLoop::Time> {
        if (interrupted()) return std::nullopt;
        return EventLoop::Time::max();
    });
    print(summarise(relay->counts()), options.json);
}

}  // namespace

Command channel_command() {
    const auto options = std::make_shared<ChannelOptions>();
    return {
        .name = "channel",
        .help =
            "Stand between a coprocessor and a hand, and lose, delay or change what the scene's channel says",
        .footer =
            "The coprocessor of a scene with a channel looks for it at the next port, or at the path with "
            ".channel\n"
            "after it. For a serial line it makes a pair of pseudo-terminals under these names.\n"
            "It stands there until Ctrl-C, which ends it with 0.\n"
            "Example, in three terminals:\n  afferent hand examples/lossy.txtpb\n  afferent channel "
            "examples/lossy.txtpb\n  afferent coprocessor examples/lossy.txtpb",
        .options = options->scene.followed_by({
            flag("--both-ways", options->both_ways,
                 "Lose and change what the hand sends as well; otherwise that is only delayed"),
            flag("--json", options->json, "Print the counts as JSON"),
        }),
        .run = [options] { run_channel(*options); },
    };
}

}  // namespace afferent
