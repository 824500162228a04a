// afferent hand: the controller's end of a scene as a process of its own.
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "afferent/apps/acknowledgement.hpp"
#include "afferent/apps/commands.hpp"
#include "afferent/apps/end_options.hpp"
#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/file_link.hpp"
#include "afferent/apps/hand_command.hpp"
#include "afferent/apps/hand_results.hpp"
#include "afferent/apps/hand_zero.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/memory_lock.hpp"
#include "afferent/apps/own_coprocessor.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/apps/waker.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/run_summary.hpp"

namespace afferent {
namespace {

class HandCommand {
  public:
    explicit HandCommand(const HandOptions& options)
        : options_(options), plan_(make_plan(options.scene.read(), Commands::wanted)) {
        auto listener = value_or_fail(
            open_listener(loop_.io(), value_or_fail(address_of(plan_, LinkEnd::hand, options.lockstep)),
                          link_options(plan_, options.lockstep)));
        Observer observer;
        observer.step = [this](const ControllerStep& step) {
            output_.step(step);
            view_.step(step);
        };
        observer.events = [this](std::span<const Event> events) {
            output_.events(events);
            view_.events(events);
        };
        observer.gap = [this](const TimeSpan& span) { view_.gap(span); };
        observer.safe = [](const std::string& reason) { say("safe state: " + reason); };
        observer.session = [this](const std::string& text) {
            say(text);
            view_.note(node_->at(), text);
        };
        observer.about_to_start_over = [this] {
            output_.about_to_start_over(*node_);
            view_.events_start_over();
        };
        observer.starting_over = [this] {
            output_.starting_over();
            view_.steps_start_over();
        };
        // In lockstep nothing may be lost: each end waits for the other.
        const bool apart = !options.lockstep;
        memory_locked_ = apart && lock_memory();
        node_ = value_or_fail(HandNode::open(plan_, std::move(listener),
                                             {.lockstep = options.lockstep,
                                              .record = options.record,
                                              .grip_thread = apart,
                                              .writes = !apart,
                                              .fed = [this] { waker_.wake(); }},
                                             std::move(observer), std::chrono::steady_clock::now));
        for (const std::string& notice : node_->output_notices()) say(notice);
        if (apart) output_.start_thread(*node_);
    }

    void run() {
        const StatusService service(loop_.io(), plan_.scene, "hand", [this] { return status_of(*node_); });
        node_->start();
        say("waiting for the coprocessor at " + node_->address());
        std::optional<OwnCoprocessor> coprocessor;
        if ((plan_.scene.hand.ability_hand && !options_.apart) || options_.with_chip)
            coprocessor.emplace(plan_.scene);
        loop_.run([this] {
            if (interrupted()) node_->interrupt();
            if (take_acknowledgement()) node_->acknowledge();
            if (take_zero_request()) node_->take_zero();
            view_.look_at(*node_);
            return node_->poll();
        });
        Summary summary = summary_of(*node_);
        if (!options_.lockstep) summary["memory_locked"] = memory_locked_;
        const bool all_written = output_.finish(*node_, summary);
        if (!all_written) leave(summary);
        view_.finish();
        // Drawn last: it takes so long that the coprocessor would take the hand for gone.
        for (const std::string& undrawn : output_.draw_pictures()) say(undrawn);
        if (!print_within(STDOUT_FILENO, text(summary, options_.json), patience))
            throw Failure("standard output: cannot be written");
        if (const auto steps = summary.find("unwritten_steps")->number(); steps && *steps > 0)
            say(unwritten(*steps));
        if (output_.failure()) throw Failure(*output_.failure());
        if (node_->failure()) throw Failure(*node_->failure());
        if (interrupted()) throw Interrupted();
        if (const auto steps = summary.find("unwritten_steps")->number(); steps && *steps > 0)
            throw Failure("not everything was written");
        const HandNode::Report report = node_->report();
        expect_whole_sessions(report.broken_sessions, report.interrupted_sessions);
    }

  private:
    static constexpr std::chrono::seconds patience{2};

    static std::string unwritten(double steps) {
        std::string digits = std::to_string(static_cast<std::uint64_t>(steps));
        for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, ",");
        return digits + " steps were not recorded";
    }

    // A thread waits for a file, a pipe or a terminal that takes nothing: only the end of the process ends
    // that.
    [[noreturn]] void leave(const Summary& summary) {
        print_within(STDOUT_FILENO, text(summary, options_.json), patience);
        say(unwritten(summary.find("unwritten_steps")->number().value_or(0)));
        say("an output has taken nothing for two seconds");
        std::_Exit(EXIT_FAILURE);
    }

    const HandOptions& options_;
    Plan plan_;
    bool memory_locked_ = false;
    EventLoop loop_;
    Waker waker_{loop_.io()};
    std::unique_ptr<HandNode> node_;
    LiveView view_{options_.view, plan_, "hand"};
    // Its thread ends before the node and the view do.
    HandResults output_{plan_, options_.out, options_.lockstep ? FullPipe::wait : FullPipe::lose_rows};
};

std::vector<Option> hand_options(HandOptions& options) {
    std::vector<Option> all = options.list(
        "force.csv, emg.csv, contact.csv, touches.csv, texture.csv, summary.json and the picture");
    all.push_back(
        flag("--apart", options.apart,
             "Wait for a coprocessor in another process, also where the sensors are on the hand's own line, "
             "which otherwise has one in this process"));
    all.push_back(flag("--zero", options.zero,
                       "Print the zero_counts of a hand on a line, which nothing touches now, and end"));
    return all;
}

}  // namespace

void run_hand(const HandOptions& options) {
    catch_interrupts();
    catch_user_signals();
    if (options.zero) return print_zero(options.scene.read());
    if (receive_from_file(options)) return;
    HandCommand(options).run();
}

Command hand_command() {
    const auto options = std::make_shared<HandOptions>();
    return {
        .name = "hand",
        .help = "Run the hand's end of a scene: packets in from a coprocessor, EMG gain out",
        .footer = std::string(EndOptions::example) +
                  "\n\nThe hand steps on a thread of its own, which waits for no link, file or terminal; "
                  "with a real-time\n"
                  "priority and locked memory where the system permits them (ulimit -r, -l). Its summary "
                  "says how late\n"
                  "its steps ran, and what could not be written.",
        .options = hand_options(*options),
        .run = [options] { run_hand(*options); },
    };
}

}  // namespace afferent
