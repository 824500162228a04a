// A hand on a link: waits for coprocessors, decodes what they send, drives the motor, and goes safe without
// them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "afferent/io/links/listener.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/grip_thread.hpp"
#include "afferent/nodes/hand_writer.hpp"
#include "afferent/nodes/link_totals.hpp"
#include "afferent/nodes/node_options.hpp"
#include "afferent/nodes/pacer.hpp"

namespace afferent {

// The node does nothing by itself: its owner runs the link's input and output, and calls poll().
//
//     while (const auto wake = node->poll()) {
//         io.restart();
//         io.run_one_until(*wake);
//         io.poll();
//     }
//
// A session that breaks off is followed by the next. In real time the hand goes on between them, frozen and
// then safe; in lockstep it waits. What steps the hand and moves its motor is a GripLoop: with
// `NodeOptions::grip_thread` on a thread of its own, which nothing here can hold up; otherwise poll() runs
// it. Nothing is thrown but what the callbacks throw.
class HandNode final : private HandClient {
  public:
    // All but the motor are called from within poll() or the link's input. Where write() writes, step, safe
    // and starting_over are called from there.
    struct Callbacks {
        // The motor: each step as soon as it is done, on the loop's thread. Must neither wait nor throw.
        std::function<void(const ControllerStep&)> motor = [](const auto&) {};
        // A scan for the coprocessor waits for poll(). Called on the loop's thread; must neither wait nor
        // throw. Where this is empty, poll() has to be called every millisecond while scans may come.
        std::function<void()> fed = {};
        // Each step of the controller, with the command to the motor.
        std::function<void(const ControllerStep&)> step = [](const auto&) {};
        // As packets come.
        std::function<void(std::span<const Event>)> events = [](auto) {};
        // Packets were lost: of this time nothing is known, and nothing will be. Before the events that
        // follow.
        std::function<void(const TimeSpan&)> gap = [](const auto&) {};
        // The hand is about to start over at another place of the scene: the report is still that of before.
        // starting_over follows, before the first step there.
        std::function<void()> about_to_start_over = [] {};
        std::function<void()> starting_over = [] {};
        // The grip has become safe; why.
        std::function<void(const std::string&)> safe = [](const auto&) {};
        // The course of the session, in words.
        std::function<void(const std::string&)> session = [](const auto&) {};
    };

    // Opens the tables that are on this side, the outputs and the recording. The plan has a controller. The
    // plan outlives the node.
    static Result<std::unique_ptr<HandNode>> open(const Plan& plan, std::unique_ptr<Listener> listener,
                                                  const NodeOptions& options, Callbacks callbacks,
                                                  MonotonicClock clock);

    // Starts to listen for coprocessors.
    void start();
    // Does everything that is due. Returns the latest time for the next call, should nothing come in before;
    // nothing if the node has come to its end.
    std::optional<MonotonicTime> poll();
    // Says bye, and comes to its end.
    void interrupt() { stop(proto::INTERRUPTED, "interrupted"); }
    // The hand's user has seen that it is safe, and lets it operate again: where the scene's hand.rearm is
    // by_user.
    void acknowledge();
    // Writes the records that wait. With `NodeOptions::writes`, poll() does so.
    void write() { writer_.write(loop_.records()); }
    // How many records wait for write().
    std::size_t waiting_records() const noexcept { return loop_.records().waiting(); }
    // What people should know of the outputs.
    std::vector<std::string> output_notices() const { return writer_.outputs().notices(); }
    // How many steps they have lost, for the thread that calls write().
    std::uint64_t lost_steps() const noexcept { return writer_.outputs().lost().steps; }
    // Completes the outputs and the recording, if there is one. To be called once, at the end.
    Result<void> close();

    // Why it has come to its end early.
    const std::optional<std::string>& failure() const noexcept { return failure_; }
    LinkAddress address() const { return listener_->address(); }

    const Plan& plan() const noexcept { return plan_; }
    // Everything before this time has been done.
    TimePoint at() const noexcept { return at_end_ ? end_ : grip_.at; }
    // Null between sessions.
    const HandSession* session() const noexcept { return session_.get(); }
    // Nothing before the hand has begun, and in lockstep.
    const std::optional<Pacer>& pacer() const noexcept { return grip_.pacer; }
    // The last report of the loop that steps the hand.
    const GripReport& grip() const noexcept { return grip_; }

    // Over all sessions.
    struct Report {
        std::uint64_t sessions = 0;
        std::uint64_t broken_sessions = 0;
        std::uint64_t interrupted_sessions = 0;  // by the peer, before the scene's end
        std::uint64_t refused_peers = 0;
        PacketCounts received;
        LinkTotals link;  // refused packets and stray datagrams included
        // Samples for the coprocessor, as frames of a stream: what a transport adds is in `link`.
        std::uint64_t feed_bytes = 0;
        std::uint64_t freezes = 0;
        std::uint64_t safe_states = 0;
        GripState state = GripState::safe;
        std::string reason;               // for the grip not to be operating
        bool real_time_priority = false;  // of the loop's thread
        // Dropped because the queues to and from the loop were full.
        std::uint64_t dropped_packets = 0;
        std::uint64_t dropped_scans = 0;
        std::uint64_t unwritten_steps = 0;
        std::uint64_t lost_events = 0;  // which an output of live events could not pass on
    };
    Report report() const;
    // What people should know of where the EMG comes from.
    const std::vector<std::string>& said_of_emg() const noexcept { return said_of_emg_; }

  private:
    HandNode(const Plan& plan, std::unique_ptr<Listener> listener, const NodeOptions& options,
             Callbacks callbacks, MonotonicClock clock, std::unique_ptr<HandSide> side, Outputs live,
             Outputs recording);

    void welcomed(const proto::Hello& hello) override;
    void received(const Reception& reception) override;
    void packet(const proto::Envelope& packet) override;
    void clock(TimePoint time) override;
    std::optional<TimePoint> scene_time() const override;
    proto::Bye answer_bye(const proto::Bye&) override { return bye(); }
    void ended(const SessionEnd& end) override;

    bool is_open() const { return session_ && session_->state() == Session::State::open; }
    void begin_where_told(TimePoint time);
    void begin(TimePoint time, std::unique_ptr<HandSide> fresh);
    TimePoint allowed() const;
    // Takes the loop's output for the link and for the writer.
    void take_from_loop();
    // To be called after something was put into the loop's inbox: where nobody else runs the loop, it is
    // taken at once.
    void settle();
    MonotonicTime run_loop();
    MonotonicTime session_due() const;
    MonotonicTime finish_scene();
    void send_samples(const FeedScan& scan);
    void send_clock(TimePoint time);
    void tell_progress();
    void look_after();
    void send_status();
    void follow_clock(MonotonicTime now);
    void steer(MonotonicTime now, Duration ahead);
    void stop(proto::ByeReason reason, const std::string& text);
    void fail(const std::string& text);
    void be_done();
    proto::Bye bye() const;

    const Plan& plan_;
    Callbacks callbacks_;
    MonotonicClock clock_;
    bool lockstep_;
    bool has_samples_;
    Duration patience_;
    LinkTiming timing_;
    TimePoint end_;  // of the scene
    std::vector<std::string> said_of_emg_;
    const proto::Hello expected_;
    GripLoop loop_;
    GripReport grip_;  // as the loop has last told
    Outputs live_;     // on the thread of poll()
    HandWriter writer_;
    bool has_thread_;
    bool writes_;
    std::optional<GripThread> thread_;
    bool thread_has_priority_ = false;
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<HandSession> session_;

    std::optional<std::string> misplaced_;  // where the coprocessor says it is: the session has to end
    MonotonicTime welcomed_at_{};
    bool welcomed_ = false;       // the session that is there
    bool started_ = false;        // where in the scene its packets belong is known
    std::optional<Pacer> place_;  // of the scene, as the loop has been told
    bool told_all_ = false;       // by the coprocessor, in lockstep: the scene's end depends on nobody else
    bool at_end_ = false;
    bool stopping_ = false;
    bool done_ = false;
    std::optional<std::string> failure_;
    TimePoint peer_at_ = TimePoint::min();  // its clock, in lockstep
    TimePoint told_ = scene_start;          // our clock, as the peer has last been told
    MonotonicTime alone_since_{};
    MonotonicTime look_after_at_{};
    MonotonicTime send_status_at_{};

    proto::Envelope feed_;
    FrameWriter frames_;
    LinkTotals ended_totals_;
    PacketCounts ended_counts_;
    std::uint64_t sessions_ = 0;
    std::uint64_t broken_sessions_ = 0;
    std::uint64_t interrupted_sessions_ = 0;
    std::uint64_t feed_bytes_ = 0;
};

}  // namespace afferent
