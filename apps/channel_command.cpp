// afferent channel: an imperfect way between a coprocessor and a hand, as a process of its own.
#include <CLI/CLI.hpp>
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
#include "afferent/io/wire/payload.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/scene/scene_link.hpp"

namespace afferent {
namespace {

struct Options {
    SceneOptions scene;
    bool both_ways = false;
    bool json = false;
};

// Of a frame that can be read; others hold none.
class EventCounter {
  public:
    explicit EventCounter(const PacketLayout& layout) : codec_(layout) {}

    std::uint32_t operator()(std::span<const std::byte> frame, bool stream) {
        if (stream) {
            reader_.emplace();
            if (frame.size() > reader_->space().size()) return 0;
            std::copy(frame.begin(), frame.end(), reader_->space().begin());
            reader_->filled(frame.size());
            const auto read = reader_->next(message_);
            if (!read || !read.value()) return 0;
        } else if (!read_datagram(frame, message_, counts_)) {
            return 0;
        }
        const auto keys = codec_.decode(std::as_bytes(std::span(message_.payload())));
        return keys ? static_cast<std::uint32_t>(keys.value().size()) : 0;
    }

  private:
    PayloadCodec codec_;
    std::optional<FrameReader> reader_;
    proto::Envelope message_;
    FrameCounts counts_;
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

RelayParameters relay_parameters(const Scene& scene, const LinkAddress& hand, bool both_ways) {
    const proto::Link& link = scene.description().link();
    RelayParameters parameters;
    parameters.to_hand = channel_parameters(link.channel(), scene.seed());
    parameters.to_coprocessor = parameters.to_hand;
    if (!both_ways) {
        ChannelParameters& back = parameters.to_coprocessor;
        back.loss = back.reorder = back.duplicate = back.corrupt = 0;
    }
    parameters.to_coprocessor.fifo_events = 0;
    if (parameters.to_hand.fifo_events > 0) {
        if (!link.keys().empty())
            throw Failure(scene.name() +
                          ": fifo_events counts events, and those of a link with keys cannot be read");
        const bool stream = !std::holds_alternative<UdpAddress>(hand);
        parameters.events = [counter = std::make_shared<EventCounter>(packet_layout(scene)),
                             stream](std::span<const std::byte> frame) { return (*counter)(frame, stream); };
    }
    return parameters;
}

void run_channel(const Options& options) {
    catch_interrupts();
    const Scene scene = options.scene.read();
    if (!scene.description().link().has_channel())
        throw Failure(scene.name() +
                      ": the link has no channel; give it one, as in link { channel { loss: 0.01 } }");
    const LinkAddress hand = value_or_fail(hand_address(scene, LinkSide::coprocessor));
    EventLoop loop;
    const auto relay = value_or_fail(Relay::open(loop.io(), channel_address(hand), hand,
                                                 relay_parameters(scene, hand, options.both_ways)));
    const StatusService service(loop.io(), scene, "channel", [&] { return summarise(relay->counts()); });
    std::cerr << "from " << text(relay->address()) << " to " << text(hand) << ", until Ctrl-C\n";
    loop.run([]() -> std::optional<EventLoop::Time> {
        if (interrupted()) return std::nullopt;
        return EventLoop::Time::max();
    });
    print(summarise(relay->counts()), options.json);
}

}  // namespace

void add_channel_command(CLI::App& app) {
    const auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "channel",
        "Stand between a coprocessor and a hand, and lose, delay or change what the scene's channel says");
    options->scene.add_to(*command);
    command->add_flag("--both-ways", options->both_ways,
                      "Lose and change what the hand sends as well; otherwise that is only delayed");
    command->add_flag("--json", options->json, "Print the counts as JSON");
    command->footer(
        "The coprocessor of a scene with a channel looks for it at the next port, or at the path with "
        ".channel\n"
        "after it. For a serial line it makes a pair of pseudo-terminals under these names.\n"
        "Example, in three terminals:\n  afferent hand examples/lossy.txtpb\n  afferent channel "
        "examples/lossy.txtpb\n  afferent coprocessor examples/lossy.txtpb");
    command->callback([options] { run_channel(*options); });
}

}  // namespace afferent
