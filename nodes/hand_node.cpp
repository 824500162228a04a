#include "afferent/nodes/hand_node.hpp"

#include <algorithm>
#include <utility>

#include "afferent/nodes/hello.hpp"

namespace afferent {
namespace {

constexpr std::chrono::milliseconds status_period{50};

// How long the hand waits, after the scene's end, for what the coprocessor has left to say; and how far a
// packet may be ahead of our clock.
constexpr Duration grace = 1s;

// In lockstep without samples, how often the hand says how far it has come.
constexpr Duration progress_period = 5ms;

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

}  // namespace

Result<std::unique_ptr<HandNode>> HandNode::open(const Plan& plan, std::unique_ptr<Listener> listener,
                                                 const NodeOptions& options, Callbacks callbacks,
                                                 MonotonicClock clock) {
    if (!plan.controller)
        return Error{
            Error::Kind::not_allowed,
            plan.scene.file + ": the plan has no controller; make_plan(scene, Commands::wanted) has one"};
    AFFERENT_TRY(side, HandSide::open(plan));
    AFFERENT_TRY(outputs, StepOutputs::open(plan));
    std::unique_ptr<HandNode> node(new HandNode(plan, std::move(listener), options.lockstep,
                                                std::move(callbacks), std::move(clock),
                                                GuardedHand(std::move(side), std::move(outputs))));
    if (!options.record.empty()) {
        auto recording = HandRecording::create(options.record, plan, proto::HAND, &node->side());
        if (!recording) return recording.error();
        node->hand_.record(std::move(recording.value()));
    }
    return node;
}

HandNode::HandNode(const Plan& plan, std::unique_ptr<Listener> listener, bool lockstep, Callbacks callbacks,
                   MonotonicClock clock, GuardedHand hand)
    : plan_(plan),
      callbacks_(std::move(callbacks)),
      clock_(std::move(clock)),
      lockstep_(lockstep),
      has_samples_(plan.samples_from == SamplesFrom::hand),
      patience_(from_seconds(plan.scene.link.connect_s)),
      timing_(plan.timing),
      end_(plan.end()),
      hand_(std::move(hand)),
      listener_(std::move(listener)) {
    hand_.on_safe = callbacks_.safe;
}

void HandNode::start() {
    alone_since_ = look_after_at_ = send_status_at_ = clock_();
    listener_->start([this](std::unique_ptr<Link> link) {
        HandClient& client = *this;
        session_ = std::make_unique<HandSession>(std::move(link), make_hello(plan_, lockstep_), client,
                                                 session_limits(lockstep_), clock_);
        session_->start();
    });
}

std::optional<MonotonicTime> HandNode::poll() {
    if (const MonotonicTime now = clock_(); now >= look_after_at_) {
        look_after();
        look_after_at_ = now + look_after_period;
    }
    const MonotonicTime wake = do_what_is_due();
    if (done_) return std::nullopt;
    return std::min(wake, look_after_at_);
}

void HandNode::welcomed(const proto::Hello& hello) {
    welcomed_ = true;
    hand_.hello(hello);
    callbacks_.session("the coprocessor is there");
    ++sessions_;
    peer_at_ = TimePoint::min();
    told_ = scene_start;
    if (!has_samples_) {
        // The coprocessor's clock will say where in the scene it is.
        if (sessions_ == 1 || start_over()) started_ = false;
        return;
    }
    if (sessions_ == 1)
        begin(scene_start);
    else
        hand_.restart(at_);
    peer_at_ = at_;
    send_clock(at_);
}

void HandNode::received(const Reception& reception) {
    callbacks_.events(reception.events);
    // The coprocessor's clock comes before its packets, unless it was lost.
    if (!started_ && !has_samples_) begin_where_told(reception.known.begin);
    if (!started_) return hand_.pass_over(reception);
    // Spans that are still to come cannot have been measured.
    if (!lockstep_ && reception.known.end > pacer_->scene_time(clock_()) + grace)
        return fail("the coprocessor reports " + std::to_string(seconds(reception.known.end)) +
                    " s, which is still to come");
    hand_.receive(reception, session_->receiver());
}

Duration HandNode::age(TimePoint time) const {
    return lockstep_ || !started_ ? Duration::zero() : pacer_->scene_time(clock_()) - time;
}

void HandNode::clock(TimePoint time) {
    if (!started_ && !has_samples_) begin_where_told(time);
    peer_at_ = std::max(peer_at_, time);
}

void HandNode::ended(const SessionEnd& end) {
    ended_totals_.add(*session_);
    add(ended_counts_, session_->receiver_counts());
    // A peer that was refused does not end the silence of the one before it.
    if (std::exchange(welcomed_, false)) {
        if (end.bye) hand_.bye(*end.bye);
        last_watchdog_ = started_ ? std::optional(session_->watchdog()) : std::nullopt;
    }
    session_.reset();
    alone_since_ = clock_();
    callbacks_.session((end.complete ? "the session has ended: " : "the session has broken off: ") +
                       end.reason);
    if (stopping_) {
        done_ = true;
    } else if (!end.complete) {
        if (sessions_ > 0) ++broken_sessions_;
    } else if (end.bye && end.bye->reason() == proto::END_OF_SCENE) {
        told_all_ = true;
    } else {
        stopping_ = done_ = true;
    }
}

void HandNode::begin_where_told(TimePoint time) {
    if (time < scene_start || time > end_)
        return fail("the coprocessor is at " + std::to_string(seconds(time)) + " s, outside of the scene");
    begin(time);
}

void HandNode::begin(TimePoint time) {
    hand_.begin(time);
    at_ = time;
    started_ = true;
    if (!lockstep_) pacer_.emplace(clock_(), time);
}

bool HandNode::start_over() {
    callbacks_.starting_over();
    auto side = HandSide::open(plan_);
    if (side)
        hand_.replace(std::move(side.value()));
    else
        fail(side.error().text);
    return side.has_value();
}

void HandNode::send_clock(TimePoint time) {
    told_ = time;
    session_->send_clock(time);
}

void HandNode::send_samples(const Scan& scan) {
    proto::Samples& samples = *feed_.mutable_samples();
    samples.set_time_ns((scan.time - scene_start).count());
    samples.set_first(scan.first);
    samples.mutable_force_n()->Assign(scan.forces_n.begin(), scan.forces_n.end());
    feed_bytes_ += writer_.stream_frame(feed_).size();
    if (is_open()) session_->send_samples(samples);
}

// Up to when everything can be done now: what is later may depend on packets that are still under way.
TimePoint HandNode::allowed() const {
    if (!lockstep_) return pacer_->scene_time(clock_());
    if (told_all_) return end_;
    if (!is_open() || peer_at_ == TimePoint::min()) return TimePoint::min();
    return peer_at_ + timing_.delivery;
}

// Returns when the next thing will be due, as far as that depends on the clock.
MonotonicTime HandNode::do_what_is_due() {
    while (started_ && !stopping_) {
        const Due due = hand_.side().next();
        if (due.time >= end_) return finish_scene();
        if (due.time > allowed()) return wall(due.time);
        follow_grip_state();
        const Result<void> done = hand_.side().do_next([this](const ControllerStep& step) { on_step(step); },
                                                       [this](const Scan& scan) { send_samples(scan); });
        if (!done) {
            fail(done.error().text);
            break;
        }
        if (pacer_) pacer_->did(due.time, clock_());
        at_ = due.time;
        if (lockstep_ && is_open()) tell_progress();
    }
    return MonotonicTime::max();
}

MonotonicTime HandNode::wall(TimePoint time) const {
    return pacer_ ? pacer_->wall(time) : MonotonicTime::max();
}

void HandNode::on_step(const ControllerStep& step) {
    callbacks_.step(step);
    hand_.did(step, is_open() ? &session_->receiver() : nullptr);
}

// With samples: all samples before this time have been sent. Without: how far the hand has come, so that the
// coprocessor does not run ahead without bounds.
void HandNode::tell_progress() {
    TimePoint told = at_;
    if (has_samples_) {
        const auto next = hand_.side().source()->next();
        told = next ? next->time : end_;
    }
    if (told > told_ && (has_samples_ || told - told_ >= progress_period)) send_clock(told);
}

MonotonicTime HandNode::finish_scene() {
    if (told_all_ || (!lockstep_ && pacer_->scene_time(clock_()) >= end_ + grace)) {
        at_ = end_;
        stop(proto::END_OF_SCENE, "");
    } else if (lockstep_ && is_open() && told_ < end_) {
        send_clock(end_);
    }
    return wall(end_ + grace);
}

std::string HandNode::reason() const {
    if (is_open()) return session_->watchdog().reason();
    return last_watchdog_ ? last_watchdog_->reason() : "";
}

GripState HandNode::permitted_state() {
    // In lockstep time waits for the coprocessor; once it has sent everything, its silence means nothing.
    if (lockstep_ || told_all_) return GripState::operating;
    if (is_open()) return session_->grip_state();
    return last_watchdog_ ? last_watchdog_->state(clock_()) : GripState::operating;
}

void HandNode::follow_grip_state() {
    if (const GripState state = permitted_state(); state != hand_.state()) hand_.follow(state, reason());
}

void HandNode::look_after() {
    if (session_) session_->poll();
    const MonotonicTime now = clock_();
    if (is_open() && started_ && !stopping_ && now >= send_status_at_) {
        send_status_at_ = now + status_period;
        send_status();
    }
    if (lockstep_ && !session_ && !told_all_ && sessions_ > 0 && now - alone_since_ > patience_)
        fail("the coprocessor has gone and has not come back in " + std::to_string(seconds(patience_)) +
             " s");
}

void HandNode::send_status() {
    proto::Status status;
    status.set_gain(hand_.side().last_step().gain);
    session_->send_status(status);
}

proto::Bye HandNode::bye() const {
    proto::Bye bye;
    bye.set_time_ns((at_ - scene_start).count());
    return bye;
}

void HandNode::stop(proto::ByeReason reason, const std::string& text) {
    if (std::exchange(stopping_, true)) return;
    if (!is_open()) {
        done_ = true;
        return;
    }
    proto::Bye last = bye();
    last.set_reason(reason);
    last.set_text(text);
    session_->say_bye(last);
}

void HandNode::fail(const std::string& text) {
    if (!failure_) failure_ = text;
    stop(proto::FAILURE, text);
}

HandNode::Report HandNode::report() const {
    Report report{.sessions = sessions_,
                  .broken_sessions = broken_sessions_,
                  .refused_peers = listener_->refused_peers(),
                  .received = ended_counts_,
                  .link = ended_totals_,
                  .feed_bytes = feed_bytes_,
                  .freezes = hand_.freezes(),
                  .safe_states = hand_.safe_states(),
                  .state = hand_.state(),
                  .reason = reason()};
    if (session_) {
        add(report.received, session_->receiver_counts());
        report.link.add(*session_);
    }
    report.link.refused_frames += report.received.refused;
    report.link.forged_datagrams += listener_->strays();
    return report;
}

}  // namespace afferent
