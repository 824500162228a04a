// afferent hand: the controller's side of a scene as a process of its own.
#include <iostream>
#include <memory>
#include <utility>
#include <vector>

#include "afferent/apps/acknowledgement.hpp"
#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/file_link.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/side_options.hpp"
#include "afferent/apps/side_summary.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/hello.hpp"

namespace afferent {
namespace {

// How many pictures are drawn of a hand that starts over again and again.
constexpr std::size_t most_pictures = 10;

class HandCommand {
  public:
    explicit HandCommand(const SideOptions& options)
        : options_(options), plan_(make_plan(options.scene.read(), Commands::wanted)) {
        auto listener = value_or_fail(
            open_listener(loop_.io(), value_or_fail(address_of(plan_, LinkSide::hand, options.lockstep)),
                          link_options(plan_, options.lockstep)));
        start_recorder();
        HandNode::Callbacks callbacks;
        callbacks.step = [this](const ControllerStep& step) { recorders_.back()->step(step); };
        callbacks.events = [this](std::span<const Event> events) { recorders_.back()->events(events); };
        callbacks.safe = [](const std::string& reason) { std::cerr << "safe state: " << reason << '\n'; };
        callbacks.session = [](const std::string& text) { std::cerr << text << '\n'; };
        callbacks.starting_over = [this] {
            recorders_.back()->close(summary_of(*node_, recorders_.back()->error()));
            if (recorders_.size() > most_pictures) recorders_.pop_back();
            start_recorder();
        };
        node_ =
            value_or_fail(HandNode::open(plan_, std::move(listener), {options.lockstep, options.record, true},
                                         std::move(callbacks), std::chrono::steady_clock::now));
    }

    void run() {
        const StatusService service(loop_.io(), plan_.scene, "hand", [this] { return status_of(*node_); });
        node_->start();
        std::cerr << "waiting for the coprocessor at " << text(node_->address()) << '\n';
        loop_.run([this] {
            if (interrupted()) node_->interrupt();
            if (take_acknowledgement()) node_->acknowledge();
            return node_->poll();
        });
        Result<void> recorded = node_->close();
        const Summary summary = summary_of(*node_, recorders_.back()->error());
        recorders_.back()->close(summary);
        // Only now: it takes so long that the coprocessor would take us for gone.
        for (const auto& recorder : recorders_)
            if (const auto undrawn = recorder->draw_picture()) std::cerr << *undrawn << '\n';
        print(summary, options_.json);
        value_or_fail(std::move(recorded));
        if (node_->failure()) throw Failure(*node_->failure());
        if (interrupted()) throw Interrupted();
    }

  private:
    void start_recorder() {
        recorders_.push_back(std::make_unique<Recorder>(plan_, session_folder(options_.out, ++starts_),
                                                        Recorder::Sides{.coprocessor = false, .hand = true}));
    }

    const SideOptions& options_;
    Plan plan_;
    EventLoop loop_;
    int starts_ = 0;
    std::vector<std::unique_ptr<Recorder>> recorders_;  // the last: of what the hand does now
    std::unique_ptr<HandNode> node_;
};

}  // namespace

Command hand_command() {
    const auto options = std::make_shared<SideOptions>();
    return {
        .name = "hand",
        .help = "Run the hand's side of a scene: packets in from a coprocessor, EMG gain out",
        .footer = SideOptions::example,
        .options = options->list("force.csv, emg.csv, summary.json and the picture"),
        .run =
            [options] {
                catch_interrupts();
                catch_acknowledgements();
                if (receive_from_file(*options)) return;
                HandCommand(*options).run();
            },
    };
}

}  // namespace afferent
