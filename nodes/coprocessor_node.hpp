// A coprocessor on a link: looks for the hand, encodes samples, and sends the events in packets.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/nodes/coprocessor_side.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/link_totals.hpp"
#include "afferent/nodes/node_options.hpp"
#include "afferent/nodes/pacer.hpp"

namespace afferent {

// Driven like a HandNode. A hand that is lost is looked for again for as long as the scene's connect_s: in
// real time the neurons go on meanwhile, in lockstep they wait. Throws nothing but what the callbacks throw.
class CoprocessorNode final : private CoprocessorClient {
  public:
    // All are called from within poll() or the link's input.
    struct Callbacks {
        // Sorted, as they are computed; where there is a bus, as they leave it.
        std::function<void(std::span<const Event>)> events = [](auto) {};
        // The neurons are about to start over at another place of the scene; the report is still that of
        // before.
        std::function<void()> starting_over = [] {};
        // The course of the session, in words.
        std::function<void(const std::string&)> session = [](const auto&) {};
    };

    // Opens the table that is on this side, and the recording. The plan outlives the node. `standard_input`
    // as for CoprocessorSide.
    static Result<std::unique_ptr<CoprocessorNode>> open(const Plan& plan,
                                                         std::unique_ptr<Connector> connector,
                                                         const NodeOptions& options, Callbacks callbacks,
                                                         MonotonicClock clock,
                                                         TableSource::Read standard_input = {});

    // Looks for the hand.
    void start();
    // Does everything that is due. Returns the latest time for the next call, should nothing come in before;
    // nothing if the node has come to its end.
    std::optional<MonotonicTime> poll();
    // Sends everything, says bye, and comes to its end.
    void interrupt();
    // The same, with a reason of the owner's that is told to the peer.
    void fail(const std::string& text);
    // Completes the recording, if there is one. To be called once, at the end.
    Result<void> close() { return recording_ ? recording_->close(at_) : Result<void>(success()); }

    // Why it has come to its end early.
    const std::optional<std::string>& failure() const noexcept { return failure_; }

    const Plan& plan() const noexcept { return plan_; }
    // Everything before this time has been done.
    TimePoint at() const noexcept { return at_; }
    CoprocessorSide& side() noexcept { return *side_; }
    const CoprocessorSide& side() const noexcept { return *side_; }
    // Null between sessions.
    const CoprocessorSession* session() const noexcept { return session_.get(); }
    // Nothing before the neurons have begun, and in lockstep.
    const std::optional<Pacer>& pacer() const noexcept { return pacer_; }

    // Over all sessions.
    struct Report {
        std::uint64_t sessions = 0;
        std::uint64_t broken_sessions = 0;
        std::uint64_t interrupted_sessions = 0;  // by the hand, before the scene's end
        LinkTotals link;
        // Packets, as frames of a stream: what a transport adds is in `link`.
        std::uint64_t packet_bytes = 0;
        double hand_gain = std::numeric_limits<double>::quiet_NaN();  // as the hand has last told
    };
    Report report() const;

  private:
    CoprocessorNode(const Plan& plan, std::unique_ptr<Connector> connector, bool lockstep,
                    Callbacks callbacks, MonotonicClock clock, std::unique_ptr<CoprocessorSide> side);

    void welcomed() override;
    void samples(const proto::Samples& samples) override;
    void clock(TimePoint time) override;
    void status(const proto::Status& status) override;
    std::optional<TimePoint> scene_time() const override;
    void ahead(Duration ahead) override;
    proto::Bye answer_bye(const proto::Bye&) override;
    void ended(const SessionEnd& end) override;

    bool is_open() const { return session_ && session_->state() == Session::State::open; }
    void connect();
    bool start_over();
    void begin(TimePoint time);
    bool plausible(TimePoint time) const;
    void close(const proto::Envelope& packet);
    void send(const proto::Envelope& packet);
    TimePoint allowed() const;
    MonotonicTime do_what_is_due();
    // How far the clock is past what was due at that time; 0 in lockstep.
    Duration behind(TimePoint due) const;
    bool do_next(Duration behind);
    bool finish(TimePoint end);
    void finish_scene();
    void tell_progress();
    void look_after();
    void stop(proto::ByeReason reason, const std::string& text);
    proto::Bye bye(proto::ByeReason reason) const;

    const Plan& plan_;
    Callbacks callbacks_;
    MonotonicClock clock_;
    bool lockstep_;
    bool follows_hand_;  // which has the samples
    Duration patience_;
    TimePoint end_;  // of the scene
    std::unique_ptr<CoprocessorSide> side_;
    CoprocessorSide::Output output_;
    std::optional<HandRecording> recording_;
    std::unique_ptr<Connector> connector_;
    proto::Hello hello_;  // of the last session
    std::unique_ptr<CoprocessorSession> session_;

    bool welcomed_ = false;  // the session that is there
    bool started_ = false;
    bool stopping_ = false;
    bool done_ = false;
    std::optional<std::string> failure_;
    std::string last_told_;
    TimePoint at_ = scene_start;
    TimePoint last_scan_ = scene_start;  // of those that the neurons were given
    proto::Envelope marked_;
    TimePoint peer_at_ = TimePoint::min();  // its clock, in lockstep
    std::optional<Pacer> pacer_;
    std::optional<Duration> first_ahead_;  // of the hand's clock, in this session
    MonotonicTime alone_since_{};
    MonotonicTime look_after_at_{};
    MonotonicTime connected_at_{};             // when the last attempt began
    std::optional<MonotonicTime> connect_at_;  // while no attempt is under way

    FrameWriter writer_;
    Report report_;  // `link` of the sessions that have ended
};

}  // namespace afferent
