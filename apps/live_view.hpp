// The view that a command is asked for with --view.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/apps/cli.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/view/view.hpp"

namespace afferent {

struct ViewOptions {
    bool view = false;
    std::uint64_t port = 0;  // 0: any free one, and an address of its own each time
    bool open = false;
    // `afferent view`: the scene begins once somebody looks, and stays on view until Ctrl-C.
    bool is_the_purpose = false;

    bool wanted() const noexcept { return view || port != 0 || open || is_the_purpose; }
    std::vector<Option> list();
};

// Does nothing where no view is asked for. Nothing here waits but what says so.
class LiveView {
  public:
    // Says the address of the page on standard error. Throws Failure.
    LiveView(const ViewOptions& options, const Plan& plan, const std::string& command);

    // Where there is a view.
    std::string url() const { return view_->url(); }

    // As for ViewFeed.
    void step(const ControllerStep& step) {
        if (view_) view_->feed().step(step);
    }
    void events(std::span<const Event> events) {
        if (view_) view_->feed().events(events);
    }
    void gap(const TimeSpan& span) {
        if (view_) view_->feed().gap(span.begin, span.end);
    }
    void steps_start_over() {
        if (view_) view_->feed().steps_start_over();
    }
    void events_start_over() {
        if (view_) view_->feed().events_start_over();
    }
    void note(TimePoint time, const std::string& text) {
        if (view_) view_->feed().note(time, text);
    }

    // Shows the present state. To be called often, on the thread that reports events.
    void look_at(const Run& run, TimePoint now, const std::optional<Pacer>& pacer);
    void look_at(const HandNode& node);
    void look_at(const CoprocessorNode& node);
    void look_at(const Replay& replay);

    // Where the view is the purpose: waits until somebody looks. False: Ctrl-C came first.
    bool wait_for_viewer() const;
    // Shows everything to its end; no other thread tells anything any more. Where the view is the purpose,
    // waits for Ctrl-C then.
    void finish();

  private:
    template <class State>
    void look(TimePoint now, const State& state);

    bool is_the_purpose_;
    std::unique_ptr<View> view_;
};

}  // namespace afferent
