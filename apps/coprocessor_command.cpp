// afferent coprocessor: the spiking end of a scene as a process of its own.
#include <memory>
#include <optional>
#include <utility>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/end_options.hpp"
#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/file_link.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/coprocessor_report.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/run_summary.hpp"

namespace afferent {
namespace {

class CoprocessorCommand {
  public:
    explicit CoprocessorCommand(const EndOptions& options)
        : options_(options), plan_(make_plan(options.scene.read_to_run())) {
        const Duration patience = from_seconds(plan_.scene.link.connect_s);
        auto connector = make_connector(
            loop_.io(), value_or_fail(address_of(plan_, LinkEnd::coprocessor, options.lockstep)),
            {.limit = std::chrono::duration_cast<std::chrono::milliseconds>(patience)},
            link_options(plan_, options.lockstep));
        start_recorder();
        Observer observer;
        observer.events = [this](std::span<const Event> events) {
            recorder_->events(events);
            view_.events(events);
        };
        observer.session = [this](const std::string& text) {
            say(text);
            view_.note(node_->at(), text);
        };
        observer.starting_over = [this] {
            recorder_->finish(summary_of(*node_));
            start_recorder();
            view_.events_start_over();
            view_.steps_start_over();
        };
        node_ = value_or_fail(CoprocessorNode::open(
            plan_, std::move(connector), {options.lockstep, options.record}, std::move(observer),
            std::chrono::steady_clock::now, blocking_standard_input()));
    }

    void run() {
        const StatusService service(loop_.io(), plan_.scene, "coprocessor",
                                    [this] { return status_of(*node_); });
        const auto input = feed_standard_input(loop_.io(), node_->link_end(),
                                               [this](const Error& error) { node_->fail(error.text); });
        node_->start();
        loop_.run([this] {
            if (interrupted()) node_->interrupt();
            view_.look_at(*node_);
            return node_->poll();
        });
        view_.finish();
        Result<void> recorded = node_->close();
        const Summary summary = summary_of(*node_);
        recorder_->finish(summary);
        print(summary, options_.json);
        value_or_fail(std::move(recorded));
        if (node_->failure()) throw Failure(*node_->failure());
        if (interrupted()) throw Interrupted();
        const CoprocessorNode::Report report = node_->report();
        expect_whole_sessions(report.broken_sessions, report.interrupted_sessions);
    }

  private:
    void start_recorder() {
        recorder_.emplace(plan_, session_folder(options_.out, ++starts_),
                          Recorder::Ends{.coprocessor = true, .hand = false});
    }

    const EndOptions& options_;
    Plan plan_;
    EventLoop loop_;
    int starts_ = 0;
    std::optional<Recorder> recorder_;
    LiveView view_{options_.view, plan_, "coprocessor"};
    std::unique_ptr<CoprocessorNode> node_;
};

}  // namespace

Command coprocessor_command() {
    const auto options = std::make_shared<EndOptions>();
    return {
        .name = "coprocessor",
        .help = "Run the spiking end of a scene: samples in, packets out to a hand",
        .footer = EndOptions::example,
        .options = options->list("events.csv and summary.json"),
        .run =
            [options] {
                catch_interrupts();
                if (send_to_file(*options)) return;
                CoprocessorCommand(*options).run();
            },
    };
}

}  // namespace afferent
