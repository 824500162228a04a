#include "afferent/nodes/hand_node.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/io/links/listener.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/nodes/ability_hand_line.hpp"
#include "afferent/nodes/grip_loop.hpp"
#include "afferent/nodes/grip_thread.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hand_report.hpp"
#include "afferent/nodes/hand_writer.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/link_totals.hpp"
#include "afferent/nodes/pacer.hpp"

namespace afferent {
namespace {

constexpr std::chrono::milliseconds status_period{50};

// How long every packet of a session may be too old before the coprocessor is asked for another session.
constexpr std::chrono::seconds time_to_prove_itself{1};

// How long the hand waits after the scene's end for the rest of the coprocessor's messages.
constexpr Duration grace = 1s;

// Clocks that are further apart than this are not steered towards each other: another session begins with
// them.
constexpr Duration most_apart = 1s;

// In lockstep without samples, how often the hand says how far it has come.
constexpr Duration progress_period = 5ms;

// How often a loop on a thread of its own is asked for scans.
constexpr std::chrono::milliseconds longest_wait_for_scans{1};

void add(PacketCounts& sum, const PacketCounts& more) {
    sum.packets += more.packets;
    sum.events += more.events;
    sum.gaps += more.gaps;
    sum.unknown += more.unknown;
    sum.lost_events += more.lost_events;
    sum.out_of_order += more.out_of_order;
    sum.refused += more.refused;
    sum.late += more.late;
    sum.stale += more.stale;
}

class HandOnLink final : public HandNode, private HandClient {
  public:
    HandOnLink(const Plan& plan, std::unique_ptr<Listener> listener, const NodeOptions& options,
               Observer observer, MonotonicClock clock, std::unique_ptr<HandEnd> link_end, Outputs live,
               Outputs recording, std::unique_ptr<HandDevice> device);
    // Keeps the plan.
    void keep(std::unique_ptr<Plan> plan) { kept_plan_ = std::move(plan); }
    // To be called before start().
    Result<void> record(const std::filesystem::path& file);

    void start() override;
    std::optional<MonotonicTime> poll() override;
    void interrupt() override { stop(proto::INTERRUPTED, "interrupted"); }
    void acknowledge() override;
    void take_zero() override {
        if (device_) device_->take_zero();
    }
    void write() override { writer_.write(loop_.records()); }
    std::size_t waiting_records() const noexcept override { return loop_.records().waiting(); }
    std::vector<std::string> output_notices() const override { return writer_.outputs().notices(); }
    std::uint64_t lost_steps() const noexcept override { return writer_.outputs().lost().steps; }
    Result<void> close() override;
    const std::optional<std::string>& failure() const noexcept override { return failure_; }
    std::string address() const override { return text(listener_->address()); }
    const Plan& plan() const noexcept override { return plan_; }
    TimePoint at() const noexcept override { return at_end_ ? end_ : grip_.at; }
    const HandSession* session() const noexcept override { return session_.get(); }
    const std::optional<Pacer>& pacer() const noexcept override { return grip_.pacer; }
    const GripReport& grip() const noexcept override { return grip_; }
    Report report() const override;
    const std::vector<std::string>& said_of_emg() const noexcept override { return said_of_emg_; }

  private:
    void welcomed(const proto::Hello& hello) override;
    void received(const Reception& reception) override;
    void packet(const proto::Envelope& packet) override;
    void clock(TimePoint time) override;
    std::optional<TimePoint> scene_time() const override;
    proto::Bye answer_bye(const proto::Bye&) override { return bye(); }
    void ended(const SessionEnd& end) override;

    bool is_open() const { return session_ && session_->state() == Session::State::open; }
    void begin_where_told(TimePoint time);
    void begin(TimePoint time, std::unique_ptr<HandEnd> fresh);
    TimePoint allowed() const;
    // Takes what the hand on the line has said.
    bool is_usable(const HandScan& scan);
    void take_from_device();
    // Takes the loop's output for the link and for the writer.
    void take_from_loop();
    // To be called after something was put into the loop's inbox: where nobody else runs the loop, it is
    // taken at once.
    void settle();
    MonotonicTime run_loop();
    MonotonicTime session_due() const;
    MonotonicTime finish_scene();
    void send_samples(TimePoint time, Address first, const std::vector<double>& forces_n);
    void send_clock(TimePoint time);
    void tell_progress();
    void look_after();
    void send_status();
    void follow_clock(MonotonicTime now);
    void steer(MonotonicTime now, std::optional<Duration> ahead);
    void stop(proto::ByeReason reason, const std::string& text);
    void fail(const std::string& text);
    void be_done();
    proto::Bye bye() const;

    std::unique_ptr<Plan> kept_plan_;  // where the node was opened from a scene
    const Plan& plan_;
    Observer observer_;
    MonotonicClock clock_;
    bool lockstep_;
    bool has_samples_;
    Duration patience_;
    LinkTiming timing_;
    TimePoint end_;  // of the scene
    std::vector<std::string> said_of_emg_;
    const proto::Hello expected_;
    std::unique_ptr<HandDevice> device_;  // null where the hand is on no line
    HandReadings readings_;               // of it
    GripLoop loop_;
    std::function<void()> fed_;
    GripReport grip_;  // as the loop has last told
    Outputs live_;     // on the thread of poll()
    HandWriter writer_;
    bool has_thread_;
    bool writes_;
    bool wakes_;  // its owner, when there is a scan
    std::optional<GripThread> thread_;
    bool thread_has_priority_ = false;
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<HandSession> session_;

    std::optional<std::string> misplaced_;  // where the coprocessor says it is: the session has to end
    MonotonicTime welcomed_at_{};
    bool welcomed_ = false;       // the session that is there
    bool started_ = false;        // where in the scene its packets belong is known
    std::optional<Pacer> pacer_;  // of the scene, as the loop has been told
    bool told_all_ = false;       // by the coprocessor, in lockstep: the scene's end depends on nobody else
    bool at_end_ = false;
    bool stopping_ = false;
    bool done_ = false;
    std::optional<std::string> failure_;
    TimePoint peer_at_ = TimePoint::min();  // its clock, in lockstep
    TimePoint told_ = scene_start;          // our clock, as the peer has last been told
    TimePoint last_scan_ = scene_start;     // of the hand on the line, as the peer has been told
    std::uint64_t refused_scans_ = 0;
    bool told_of_scans_ = false;
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

HandOnLink::HandOnLink(const Plan& plan, std::unique_ptr<Listener> listener, const NodeOptions& options,
                       Observer observer, MonotonicClock clock, std::unique_ptr<HandEnd> link_end,
                       Outputs live, Outputs recording, std::unique_ptr<HandDevice> device)
    : plan_(plan),
      observer_(std::move(observer)),
      clock_(std::move(clock)),
      lockstep_(options.lockstep),
      has_samples_(plan.samples_from == SamplesFrom::hand),
      patience_(from_seconds(plan.scene.link.connect_s)),
      timing_(plan.timing),
      end_(plan.end()),
      said_of_emg_(link_end->said_of_emg()),
      expected_(make_hello(plan, options.lockstep)),
      device_(std::move(device)),
      loop_(plan, std::move(link_end),
            {.lockstep = options.lockstep,
             .keeps_messages = !options.record.empty(),
             .motor = options.motor,
             .device = device_.get(),
             .fed = options.fed ? options.fed : [] {}},
            clock_),
      fed_(options.fed ? options.fed : [] {}),
      grip_(loop_.report()),
      live_(std::move(live)),
      writer_(std::move(recording), observer_),
      has_thread_(options.grip_thread && !options.lockstep),
      writes_(options.writes),
      wakes_(options.fed != nullptr),
      listener_(std::move(listener)) {}

void HandOnLink::start() {
    alone_since_ = look_after_at_ = send_status_at_ = clock_();
    if (has_thread_) {
        thread_.emplace(loop_);
        thread_has_priority_ = thread_->has_priority();
    }
    if (device_) device_->start(fed_);
    listener_->start([this](std::unique_ptr<Link> link) {
        HandClient& client = *this;
        session_ = std::make_unique<HandSession>(std::move(link), expected_, client,
                                                 session_limits(plan_, lockstep_), clock_);
        session_->start();
    });
}

void HandOnLink::acknowledge() {
    loop_.inbox().acknowledged(clock_());
    settle();
}

std::optional<MonotonicTime> HandOnLink::poll() {
    if (const MonotonicTime now = clock_(); now >= look_after_at_) {
        look_after();
        look_after_at_ = now + look_after_period;
    }
    if (session_due() <= clock_()) session_->poll();
    take_from_device();
    MonotonicTime wake = std::min(run_loop(), session_due());
    if (const auto failure = loop_.failure()) fail(*failure);
    if (grip_.at_end) wake = std::min(wake, finish_scene());
    if (done_) return std::nullopt;
    return std::min(wake, look_after_at_);
}

MonotonicTime HandOnLink::session_due() const {
    return is_open() ? session_->due().value_or(MonotonicTime::max()) : MonotonicTime::max();
}

MonotonicTime HandOnLink::run_loop() {
    loop_.inbox().flush();
    if (thread_) {
        take_from_loop();
        // A scan is to be sent when it is there.
        const bool asks = has_samples_ && is_open() && !wakes_;
        return asks ? clock_() + longest_wait_for_scans : MonotonicTime::max();
    }
    loop_.allow(allowed());
    const MonotonicTime wake = loop_.poll([this] { take_from_loop(); });
    take_from_loop();
    return wake;
}

// A hand that does not keep to hand_device.hpp has said nothing: its samples are missing, and the grip goes
// safe.
bool HandOnLink::is_usable(const HandScan& scan) {
    std::string why;
    if (scan.forces_n.size() != plan_.elements)
        why = std::to_string(scan.forces_n.size()) + " forces of " + std::to_string(plan_.elements) +
              " elements";
    else if (!std::ranges::all_of(scan.forces_n,
                                  [](double force_n) { return force_n >= 0 && std::isfinite(force_n); }))
        why = "a force that is negative or no number";
    else if (scan.at > clock_())
        why = "a time that is still to come";
    if (why.empty()) return true;
    ++refused_scans_;
    if (!std::exchange(told_of_scans_, true)) observer_.session("scans of the hand are not used: " + why);
    return false;
}

void HandOnLink::take_from_device() {
    if (!device_) return;
    while (const HandScan* scan = device_->next_scan()) {
        if (!is_open() || !is_usable(*scan)) continue;
        const TimePoint time = pacer_->scene_time(scan->at);
        // A clock that is steered may go back a little.
        if (time <= last_scan_ || time > end_) continue;
        last_scan_ = time;
        send_samples(time, 0, scan->forces_n);
    }
    while (const auto note = device_->next_note()) observer_.session(*note);
    readings_ = device_->readings();
}

void HandOnLink::settle() {
    if (thread_) return;
    loop_.take_inputs();
    take_from_loop();
}

void HandOnLink::take_from_loop() {
    if (writes_) write();
    while (const FeedScan* scan = loop_.scans().next()) {
        send_samples(scan->time, scan->first, scan->forces_n);
        loop_.scans().pop();
    }
    grip_ = loop_.report();
    if (lockstep_ && is_open()) tell_progress();
}

void HandOnLink::welcomed(const proto::Hello& hello) {
    welcomed_ = true;
    welcomed_at_ = clock_();
    misplaced_.reset();
    loop_.inbox().opened(clock_(), hello);
    settle();
    observer_.session("the coprocessor is there");
    ++sessions_;
    peer_at_ = TimePoint::min();
    told_ = scene_start;
    if (!has_samples_) {
        // The coprocessor's clock will say where in the scene it is; until then the hand goes on where it is.
        started_ = false;
        return;
    }
    if (sessions_ == 1) {
        begin(scene_start, nullptr);
    } else {
        loop_.inbox().restart(clock_());
        settle();
    }
    peer_at_ = grip_.at;
    send_clock(grip_.at);
}

void HandOnLink::received(const Reception& reception) {
    if (reception.gap) observer_.gap(*reception.gap);
    live_.observe(reception.known, reception.events);
    observer_.events(reception.events);
    // The coprocessor's clock comes before its packets, unless it was lost.
    if (!started_) begin_where_told(reception.known.begin);
    if (!started_) return;
    const PacketReceiver& receiver = session_->receiver();
    loop_.inbox().receive(reception, {receiver.position(), receiver.counted_events()},
                          clock_() - reception.waited);
}

void HandOnLink::packet(const proto::Envelope& packet) {
    if (!started_) return;
    loop_.inbox().packet(packet);
    settle();
}

std::optional<TimePoint> HandOnLink::scene_time() const {
    return pacer_ && started_ ? std::optional(pacer_->scene_time(clock_())) : std::nullopt;
}

void HandOnLink::clock(TimePoint time) {
    if (!started_) begin_where_told(time);
    peer_at_ = std::max(peer_at_, time);
}

void HandOnLink::ended(const SessionEnd& end) {
    ended_totals_.add(*session_);
    add(ended_counts_, session_->receiver_counts());
    // The refusal of a peer does not end the session before it.
    const bool was_welcome = std::exchange(welcomed_, false);
    if (was_welcome) {
        loop_.inbox().ended(clock_(), end.bye);
        if (pacer_) steer(clock_(), std::nullopt);
        settle();
    }
    session_.reset();
    alone_since_ = clock_();
    if (end.bye && end.bye->reason() != proto::END_OF_SCENE && !stopping_) ++interrupted_sessions_;
    observer_.session((end.complete ? "the session has ended: " : "the session has broken off: ") +
                      end.reason);
    if (stopping_) {
        be_done();
    } else if (!end.complete) {
        if (was_welcome) ++broken_sessions_;
    } else if (lockstep_) {
        // In real time only the hand's own user ends it: otherwise it waits for the next session.
        if (end.bye->reason() == proto::END_OF_SCENE)
            told_all_ = true;
        else
            stop(proto::INTERRUPTED, "");
    }
}

void HandOnLink::begin_where_told(TimePoint time) {
    // No time on the wire is before the scene's start.
    if (time > end_) {
        const std::string text =
            "the coprocessor is at " + std::to_string(seconds(time)) + " s, outside of the scene";
        if (lockstep_) return fail(text);
        // The session is ended later: this is called from within it.
        misplaced_ = text;
        return;
    }
    if (sessions_ == 1) return begin(time, nullptr);
    auto fresh = HandEnd::open(plan_);
    if (!fresh) return fail(fresh.error().text);
    observer_.about_to_start_over();
    begin(time, std::move(fresh.value()));
}

void HandOnLink::begin(TimePoint time, std::unique_ptr<HandEnd> fresh) {
    started_ = true;
    const MonotonicTime now = clock_();
    if (!lockstep_) pacer_.emplace(now, time);
    loop_.inbox().begin(now, time, std::move(fresh));
    settle();
}

void HandOnLink::send_clock(TimePoint time) {
    told_ = time;
    session_->send_clock(time);
}

void HandOnLink::send_samples(TimePoint time, Address first, const std::vector<double>& forces_n) {
    proto::Samples& samples = *feed_.mutable_samples();
    samples.set_time_ns((time - scene_start).count());
    samples.set_first(first);
    samples.mutable_force_n()->Assign(forces_n.begin(), forces_n.end());
    feed_bytes_ += frames_.stream_frame(feed_).size();
    if (is_open()) session_->send_samples(samples);
}

// The time up to which everything can be done already: what is later may depend on packets that are under
// way.
TimePoint HandOnLink::allowed() const { return told_all_ ? end_ : peer_at_ + timing_.delivery; }

// Where the samples are the hand's: all samples before this time have been sent. Otherwise: how far the hand
// has come, which bounds how far the coprocessor runs ahead.
void HandOnLink::tell_progress() {
    const TimePoint told = has_samples_ ? grip_.next_scan.value_or(end_) : grip_.at;
    if (told - told_ >= (has_samples_ ? 1ns : progress_period)) send_clock(told);
}

// Ends the scene by the hand's own clock, or in lockstep when the coprocessor has told everything.
MonotonicTime HandOnLink::finish_scene() {
    if (lockstep_) {
        if (told_all_) {
            at_end_ = true;
            stop(proto::END_OF_SCENE, "");
        }
        return MonotonicTime::max();
    }
    const MonotonicTime last = pacer_->wall(is_open() ? end_ + grace : end_);
    if (clock_() < last) return last;
    at_end_ = true;
    stop(proto::END_OF_SCENE, "");
    return MonotonicTime::max();
}

void HandOnLink::look_after() {
    if (session_) session_->poll();
    if (session_ && misplaced_) session_->break_off(*misplaced_);
    const MonotonicTime now = clock_();
    if (is_open() && grip_.begun && now >= send_status_at_) {
        send_status_at_ = now + status_period;
        send_status();
        follow_clock(now);
    }
    if (lockstep_ && !session_ && !told_all_ && sessions_ > 0 && now - alone_since_ > patience_)
        fail("the coprocessor has gone and has not come back in " + std::to_string(seconds(patience_)) +
             " s");
}

void HandOnLink::send_status() {
    proto::Status status;
    status.set_gain(grip_.last_step.gain);
    status.set_state(as_message(grip_.state));
    if (grip_.state != GripState::operating) status.set_reason(text(grip_.cause));
    // A coprocessor that began behind our clock, because its first message was held up, stays behind.
    const bool began_late = grip_.state == GripState::safe &&
                            grip_.cause.kind == GripCause::Kind::stale_packets &&
                            clock_() - welcomed_at_ >= time_to_prove_itself;
    // The loop may not have heard of this session yet, and speak of the one before. In lockstep a coprocessor
    // may take any time.
    const bool is_of_this_session = grip_.sessions == sessions_;
    status.set_needs_session(!lockstep_ && is_of_this_session && (grip_.spent || began_late));
    session_->send_status(status);
}

// Where the samples are the coprocessor's, the scene's time is its clock's; otherwise it keeps to ours.
void HandOnLink::follow_clock(MonotonicTime now) {
    const auto ahead = session_->ahead();
    if (!ahead) return;
    if (std::chrono::abs(*ahead) > most_apart)
        return session_->break_off("the coprocessor's clock is " +
                                   std::to_string(std::chrono::abs(*ahead) / 1ms) + " ms " +
                                   (*ahead > Duration::zero() ? "ahead of" : "behind") + " the hand's");
    if (!has_samples_) steer(now, *ahead);
}

void HandOnLink::steer(MonotonicTime now, std::optional<Duration> ahead) {
    pacer_->steer(now, ahead);
    loop_.inbox().steer(now, ahead);
    settle();
}

proto::Bye HandOnLink::bye() const {
    proto::Bye bye;
    bye.set_time_ns((at() - scene_start).count());
    return bye;
}

void HandOnLink::stop(proto::ByeReason reason, const std::string& text) {
    if (std::exchange(stopping_, true)) return;
    loop_.inbox().stop();
    settle();
    if (!is_open()) return be_done();
    proto::Bye last = bye();
    last.set_reason(reason);
    last.set_text(text);
    session_->say_bye(last);
}

void HandOnLink::fail(const std::string& text) {
    if (!failure_) failure_ = text;
    stop(proto::FAILURE, text);
}

void HandOnLink::be_done() {
    thread_.reset();
    take_from_device();
    take_from_loop();
    done_ = true;
}

Result<void> HandOnLink::close() {
    write();
    AFFERENT_TRY(live_.close());
    return writer_.close(loop_.records(), at());
}

HandNode::Report HandOnLink::report() const {
    Report report{.sessions = sessions_,
                  .broken_sessions = broken_sessions_,
                  .interrupted_sessions = interrupted_sessions_,
                  .refused_peers = listener_->refused_peers(),
                  .received = ended_counts_,
                  .link = ended_totals_,
                  .feed_bytes = feed_bytes_,
                  .freezes = grip_.freezes,
                  .safe_states = grip_.safe_states,
                  .state = grip_.state,
                  .reason = grip_.state == GripState::operating ? "" : text(grip_.cause),
                  .real_time_priority = thread_has_priority_,
                  .dropped_packets = loop_.inbox().dropped() + grip_.dropped_packets,
                  .dropped_scans = grip_.dropped_scans,
                  .unwritten_steps = grip_.lost_steps,
                  .lost_events = live_.lost().events};
    if (device_) {
        report.hand = readings_;
        report.dropped_scans += device_->dropped_scans() + refused_scans_;
    }
    if (session_) {
        add(report.received, session_->receiver_counts());
        report.link.add(*session_);
    }
    report.received.late = grip_.late_packets;
    report.link.forged_datagrams += listener_->strays();
    return report;
}

Result<void> HandOnLink::record(const std::filesystem::path& file) {
    AFFERENT_TRY(recording, HandRecording::create(file, plan_, proto::HAND, &loop_.link_end()));
    writer_.record(std::move(recording));
    return success();
}

Result<std::unique_ptr<HandOnLink>> open_on_link(const Plan& plan, std::unique_ptr<Listener> listener,
                                                 const NodeOptions& options, Observer observer,
                                                 MonotonicClock clock, std::unique_ptr<HandDevice> device) {
    if (!plan.controller)
        return Error{
            Error::Kind::not_allowed,
            plan.scene.file + ": the plan has no controller; make_plan(scene, Commands::wanted) has one"};
    AFFERENT_TRY(link_end, HandEnd::open(plan));
    if (plan.scene.hand.ability_hand) {
        if (options.lockstep)
            return Error{Error::Kind::not_allowed,
                         plan.scene.file + ": hand.ability_hand moves in real time, and not in lockstep"};
        if (!device) {
            AFFERENT_TRY(opened, open_ability_hand(plan));
            device = std::move(opened);
        }
    } else if (device) {
        return Error{Error::Kind::not_allowed,
                     plan.scene.file +
                         ": a hand is given, and the scene's samples are not its: it has no "
                         "hand.ability_hand"};
    }
    // The thread that steps a hand reads no file.
    if (options.grip_thread && link_end->source()) {
        AFFERENT_TRY(link_end->source()->read_all());
    }
    // In real time the hand waits for nobody.
    const FullPipe full_pipe = options.lockstep ? FullPipe::wait : FullPipe::lose_rows;
    AFFERENT_TRY(recording, Outputs::open(plan.scene, OutputThread::writer, full_pipe));
    AFFERENT_TRY(live, Outputs::open(plan.scene, OutputThread::link, full_pipe));
    auto node = std::make_unique<HandOnLink>(plan, std::move(listener), options, std::move(observer),
                                             std::move(clock), std::move(link_end), std::move(live),
                                             std::move(recording), std::move(device));
    if (!options.record.empty()) {
        AFFERENT_TRY(node->record(options.record));
    }
    return node;
}

}  // namespace

Result<std::unique_ptr<HandNode>> HandNode::open(const Plan& plan, std::unique_ptr<Listener> listener,
                                                 const NodeOptions& options, Observer observer,
                                                 MonotonicClock clock) {
    return open(plan, std::move(listener), options, std::move(observer), std::move(clock), nullptr);
}

Result<std::unique_ptr<HandNode>> HandNode::open(const Plan& plan, std::unique_ptr<Listener> listener,
                                                 const NodeOptions& options, Observer observer,
                                                 MonotonicClock clock, std::unique_ptr<HandDevice> device) {
    AFFERENT_TRY(node, open_on_link(plan, std::move(listener), options, std::move(observer), std::move(clock),
                                    std::move(device)));
    return std::unique_ptr<HandNode>(std::move(node));
}

Result<std::unique_ptr<HandNode>> HandNode::open(const Scene& scene, boost::asio::io_context& io,
                                                 const NodeOptions& options, Observer observer) {
    auto plan = std::make_unique<Plan>(make_plan(scene, Commands::wanted));
    AFFERENT_TRY(address, address_of(*plan, LinkEnd::hand, options.lockstep));
    AFFERENT_TRY(listener, open_listener(io, address, link_options(*plan, options.lockstep)));
    AFFERENT_TRY(node, open_on_link(*plan, std::move(listener), options, std::move(observer),
                                    std::chrono::steady_clock::now, nullptr));
    node->keep(std::move(plan));
    return std::unique_ptr<HandNode>(std::move(node));
}

}  // namespace afferent
