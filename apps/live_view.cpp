#include "afferent/apps/live_view.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/print_at_once.hpp"
#include "afferent/apps/private_folder.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_report.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/run_summary.hpp"

extern char** environ;

namespace afferent {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double highest_port = 65'535;

void open_in_browser(const std::string& url) {
    std::array<std::string, 2> words{"xdg-open", url};
    std::array<char*, 3> argv{words[0].data(), words[1].data(), nullptr};
    // xdg-open's messages about the browsers that it tries would mix with the scene's.
    posix_spawn_file_actions_t silent;
    ::posix_spawn_file_actions_init(&silent);
    for (const int file : {STDOUT_FILENO, STDERR_FILENO})
        ::posix_spawn_file_actions_addopen(&silent, file, "/dev/null", O_WRONLY, 0);
    // A browser outlives this program: it should keep none of its sockets, and not end with its Ctrl-C.
    ::posix_spawn_file_actions_addclosefrom_np(&silent, STDERR_FILENO + 1);
    posix_spawnattr_t apart;
    ::posix_spawnattr_init(&apart);
    ::posix_spawnattr_setflags(&apart, POSIX_SPAWN_SETPGROUP);
    pid_t child = 0;
    const int failed = ::posix_spawnp(&child, argv[0], &silent, &apart, argv.data(), environ);
    ::posix_spawnattr_destroy(&apart);
    ::posix_spawn_file_actions_destroy(&silent);
    if (failed != 0) say("--open: there is no xdg-open here; open the address yourself");
}

void add(LinkState& state, const PacketCounts& received) {
    state.packets = received.packets;
    state.events = received.events;
    state.gaps = received.gaps;
    state.lost_events = received.lost_events;
    state.late_packets = received.late;
    state.stale_packets = received.stale;
}

void add(LinkState& state, const std::optional<Pacer>& pacer) {
    if (pacer) state.missed_deadlines = pacer->missed_deadlines();
}

}  // namespace

std::vector<Option> ViewOptions::list() {
    return {
        flag("--view", view, "Show it in a browser on this machine, at the address that is printed"),
        option("--view-port", port,
               "Port of the view, in place of any free one; the address then stays the same from one start "
               "to the "
               "next")
            .within(1, highest_port),
        flag("--open", open, "Open the view in the browser (xdg-open)"),
    };
}

LiveView::LiveView(const ViewOptions& options, const Plan& plan, const std::string& command)
    : is_the_purpose_(options.is_the_purpose) {
    if (!options.wanted()) return;
    View::Options how{.command = command, .port = static_cast<std::uint16_t>(options.port)};
    if (options.port != 0)
        if (const auto folder = private_folder())
            how.token_file = *folder / ("view-" + std::to_string(options.port));
    view_ = value_or_fail(View::open(plan, how));
    say("view: " + view_->url());
    if (options.open) open_in_browser(view_->url());
}

template <class State>
void LiveView::look(TimePoint now, const State& state) {
    view_->feed().silent_until(now);
    view_->feed().link(Clock::now(), state);
}

void LiveView::look_at(const Run& run, TimePoint now, const std::optional<Pacer>& pacer) {
    if (!view_) return;
    look(now, [&] {
        LinkState state{.time = now, .session = "in one process", .sessions = 1, .bytes = run.link_bytes()};
        add(state, run.received());
        if (!run.channel()) state.events = run.coprocessor().events();
        state.packets = run.packets();
        if (run.hand()) state.grip = name(run.hand()->state());
        state.reason = run.safe_reason();
        add(state, pacer);
        return state;
    });
}

void LiveView::look_at(const HandNode& node) {
    if (!view_) return;
    // Without packets there is nothing to be known of events.
    const bool is_told = node.session() && node.session()->state() == Session::State::open;
    if (!is_told) view_->feed().events_unknown();
    look(is_told ? node.at() : scene_start, [&] {
        const HandNode::Report report = node.report();
        LinkState state{.time = node.at(),
                        .session = name(node.session()),
                        .sessions = report.sessions,
                        .bytes = report.link.bytes_received};
        add(state, report.received);
        state.dropped_packets = report.dropped_packets;
        state.refused_frames = report.link.refused_frames + report.link.checksum_failures;
        state.grip = name(report.state);
        state.reason = report.reason;
        if (node.pacer()) {
            const GripReport::Lateness& late = node.grip().step_lateness;
            state.lateness_p50_ms = Milliseconds(late.p50).count();
            state.lateness_p99_ms = Milliseconds(late.p99).count();
            state.lateness_max_ms = Milliseconds(late.max).count();
        }
        add(state, node.pacer());
        if (report.hand) {
            for (std::size_t i = 0; i < report.hand->motor_count; ++i) {
                const HandReadings::Motor& motor = report.hand->motors[i];
                state.motors.push_back({motor.name, motor.position_deg, motor.current_a});
            }
            state.temperature = !report.hand->answering ? "unknown: the hand does not answer"
                                : report.hand->temperature_status == 0
                                    ? "normal"
                                    : "status " + std::to_string(report.hand->temperature_status);
        }
        return state;
    });
}

void LiveView::look_at(const CoprocessorNode& node) {
    if (!view_) return;
    ViewSample sample{.time = node.at()};
    if (const SampleSource* source = node.link_end().source())
        sample.true_n = source->true_force_n(node.at()).value_or(not_known);
    sample.gain = node.session() ? node.report().hand_gain : not_known;
    view_->feed().sample(sample);
    look(node.at(), [&] {
        const CoprocessorNode::Report report = node.report();
        LinkState state{.time = node.at(),
                        .session = name(node.session()),
                        .sessions = report.sessions,
                        .packets = node.link_end().packetizer()->packets(),
                        .events = node.link_end().events(),
                        .bytes = report.link.bytes_sent};
        state.dropped_packets = report.link.dropped_packets;
        state.refused_frames = report.link.refused_frames + report.link.checksum_failures;
        add(state, node.pacer());
        return state;
    });
}

void LiveView::look_at(const Replay& replay) {
    if (!view_) return;
    look(replay.now(), [&] {
        const ReplayCounts counts = replay.counts();
        LinkState state{.time = replay.now(),
                        .session = "recorded",
                        .sessions = counts.sessions,
                        .packets = counts.packets,
                        .events = counts.events,
                        .gaps = counts.gaps,
                        .lost_events = counts.lost_events,
                        .late_packets = counts.late};
        state.refused_frames = counts.refused;
        return state;
    });
}

bool LiveView::wait_for_viewer() const {
    if (!view_ || !is_the_purpose_) return true;
    say("The scene begins once a browser shows this page; Ctrl-C ends.");
    while (!interrupted() && view_->viewers() == 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return !interrupted();
}

void LiveView::finish() {
    if (!view_) return;
    view_->feed().steps_end();
    view_->feed().events_end();
    if (is_the_purpose_ && !interrupted()) {
        view_->end();
        say("The scene has come to its end; its last minute stays on view until Ctrl-C.");
        while (!interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    view_.reset();
}

}  // namespace afferent
