#include "afferent/nodes/coprocessor_node.hpp"

#include <algorithm>
#include <utility>

#include "afferent/io/wire/printable.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent {
namespace {

// How far samples of our own may run ahead of the hand in lockstep.
constexpr Duration lead = 200ms;

// How far the time stamps of a hand may be ahead of our clock: more cannot be under way.
constexpr Duration plausible_lead = 10s;

// The pause before another attempt to open a session with a hand that does not accept one.
constexpr std::chrono::milliseconds pause_between_attempts{250};

}  // namespace

Result<std::unique_ptr<CoprocessorNode>> CoprocessorNode::open(const Plan& plan,
                                                               std::unique_ptr<Connector> connector,
                                                               const NodeOptions& options,
                                                               Callbacks callbacks, MonotonicClock clock,
                                                               TableSource::Read standard_input) {
    auto side = CoprocessorSide::open(plan, std::move(standard_input));
    if (!side) return side.error();
    std::unique_ptr<CoprocessorNode> node(new CoprocessorNode(plan, std::move(connector), options.lockstep,
                                                              std::move(callbacks), std::move(clock),
                                                              std::move(side.value())));
    if (!options.record.empty()) {
        auto recording = HandRecording::create(options.record, plan, proto::COPROCESSOR, nullptr);
        if (!recording) return recording.error();
        node->recording_ = std::move(recording.value());
    }
    return node;
}

CoprocessorNode::CoprocessorNode(const Plan& plan, std::unique_ptr<Connector> connector, bool lockstep,
                                 Callbacks callbacks, MonotonicClock clock,
                                 std::unique_ptr<CoprocessorSide> side)
    : plan_(plan),
      callbacks_(std::move(callbacks)),
      clock_(std::move(clock)),
      lockstep_(lockstep),
      follows_hand_(plan.samples_from == SamplesFrom::hand),
      patience_(from_seconds(plan.scene.link.connect_s)),
      end_(plan.end()),
      side_(std::move(side)),
      connector_(std::move(connector)) {
    output_.events = callbacks_.events;
    output_.scan = [this](const Scan& scan) { last_scan_ = std::max(last_scan_, scan.time); };
    output_.packet = [this](const proto::Envelope& packet) { close(packet); };
}

void CoprocessorNode::start() {
    alone_since_ = look_after_at_ = clock_();
    connect();
}

void CoprocessorNode::connect() {
    connect_at_.reset();
    connected_at_ = clock_();
    connector_->start([this](Result<std::unique_ptr<Link>> link) {
        if (!link) return fail(link.error().text);
        hello_ = make_hello(plan_, lockstep_);
        CoprocessorClient& client = *this;
        session_ = std::make_unique<CoprocessorSession>(std::move(link.value()), hello_, client,
                                                        session_limits(plan_, lockstep_), clock_);
        session_->start();
    });
}

std::optional<MonotonicTime> CoprocessorNode::poll() {
    if (const MonotonicTime now = clock_(); now >= look_after_at_) {
        look_after();
        look_after_at_ = now + look_after_period;
    }
    const MonotonicTime wake = do_what_is_due();
    if (done_) return std::nullopt;
    return std::min(wake, look_after_at_);
}

void CoprocessorNode::look_after() {
    if (session_) session_->poll();
    if (connect_at_ && !stopping_ && clock_() >= *connect_at_) connect();
}

void CoprocessorNode::interrupt() {
    if (stopping_) return;
    if (started_ && !finish(at_)) return;
    stop(proto::INTERRUPTED, "interrupted");
}

void CoprocessorNode::welcomed() {
    callbacks_.session("the hand is there");
    ++report_.sessions;
    welcomed_ = true;
    first_ahead_.reset();
    if (recording_) recording_->hello(hello_);
    if (follows_hand_) {
        // The hand's clock tells where in the scene to start over; samples taken while it was away are lost.
        if (report_.sessions > 1 && !start_over()) return;
        started_ = false;
        peer_at_ = TimePoint::min();
        return;
    }
    if (!started_)
        begin(scene_start);
    else if (recording_)
        recording_->begin(at_, false);
    session_->send_clock(at_);
    if (lockstep_) tell_progress();
    if (report_.sessions > 1 && side_->packetizer()) side_->packetizer()->announce();
}

bool CoprocessorNode::start_over() {
    callbacks_.starting_over();
    auto side = CoprocessorSide::open(plan_);
    if (side)
        side_ = std::move(side.value());
    else
        fail(side.error().text);
    return side.has_value();
}

void CoprocessorNode::samples(const proto::Samples& samples) {
    const std::span<const double> forces_n(samples.force_n().data(),
                                           static_cast<std::size_t>(samples.force_n_size()));
    const TimePoint time = scene_start + Duration(samples.time_ns());
    if (!plausible(time))
        return fail("the hand sends samples from " + std::to_string(seconds(time)) + " s, far from " +
                    std::to_string(seconds(at_)) + " s");
    // The hand's clock comes before them, unless it was lost.
    if (follows_hand_ && !started_) begin(time);
    side_->push({time, samples.first(), forces_n}, output_, behind(side_->next().time));
}

bool CoprocessorNode::plausible(TimePoint time) const {
    return time >= scene_start && time <= end_ && (lockstep_ || !started_ || time < at_ + plausible_lead);
}

void CoprocessorNode::clock(TimePoint time) {
    if (follows_hand_ && !started_) {
        if (time < scene_start || time > end_) return fail("the hand sends a clock outside of the scene");
        begin(time);
    }
    peer_at_ = std::max(peer_at_, time);
}

void CoprocessorNode::status(const proto::Status& status) {
    report_.hand_gain = status.gain();
    if (status.needs_session())
        session_->break_off("the hand is safe until another session: " + printable(status.reason()));
}

std::optional<TimePoint> CoprocessorNode::scene_time() const {
    return pacer_ && started_ ? std::optional(pacer_->scene_time(clock_())) : std::nullopt;
}

// Samples arrive with a delay, and our clock began behind the hand's by that delay. It keeps that distance.
void CoprocessorNode::ahead(Duration ahead) {
    if (!follows_hand_ || !pacer_) return;
    if (!first_ahead_) first_ahead_ = ahead;
    pacer_->steer(clock_(), *first_ahead_ - ahead);
}

proto::Bye CoprocessorNode::answer_bye(const proto::Bye&) {
    const proto::Bye last = bye(proto::END_OF_SCENE);
    if (recording_) recording_->bye(last);
    return last;
}

void CoprocessorNode::ended(const SessionEnd& end) {
    report_.link.add(*session_);
    session_.reset();
    const bool was_welcome = std::exchange(welcomed_, false);
    // In real time, a session that the hand gives up may be followed by another.
    const bool given_up = !lockstep_ && end.bye && end.bye->reason() == proto::FAILURE;
    const bool over = end.complete && !given_up;
    const std::string told = (over ? "the session has ended: " : "the session has broken off: ") + end.reason;
    // A hand that has another coprocessor turns us away four times a second: that is told once.
    if (told != last_told_ || was_welcome) callbacks_.session(told);
    last_told_ = told;
    if (over && end.bye && end.bye->reason() != proto::END_OF_SCENE && !stopping_)
        ++report_.interrupted_sessions;
    if (over || stopping_) {
        stopping_ = done_ = true;
        return;
    }
    if (pacer_) pacer_->steer(clock_(), Duration::zero());
    if (was_welcome) {
        ++report_.broken_sessions;
        alone_since_ = clock_();
        // If the hand ends one session after another, the next attempt waits.
        if (alone_since_ - connected_at_ >= pause_between_attempts) return connect();
    }
    // Sides that do not fit now will not fit later. But a hand may have another coprocessor for a while, or
    // too many others that have only connected.
    const bool hopeless = !was_welcome && !end.unanswered;
    if (hopeless || clock_() - alone_since_ > patience_) return fail(end.reason);
    connect_at_ = clock_() + pause_between_attempts;
}

void CoprocessorNode::begin(TimePoint time) {
    side_->begin_at(time);
    if (recording_) recording_->begin(time, report_.sessions == 1);
    at_ = last_scan_ = time;
    started_ = true;
    if (!lockstep_)
        pacer_.emplace(clock_(), time);
    else if (follows_hand_)
        tell_progress();
}

// Sends a packet that ends now. If the sensors have been silent, or their scans skipped, for as long as a
// link may be silent before the hand freezes, the packet says so: spikes from forces that are only held
// measure nothing.
void CoprocessorNode::close(const proto::Envelope& packet) {
    const bool silent = !lockstep_ && side_->deadline() - last_scan_ > plan_.timing.freeze;
    const bool skipping = side_->overdue() && !side_->overdue()->empty();
    if (!silent || !(side_->awaits_samples() || skipping)) return send(packet);
    marked_ = packet;
    marked_.set_no_samples_since_ns((last_scan_ - scene_start).count());
    send(marked_);
}

void CoprocessorNode::send(const proto::Envelope& packet) {
    report_.packet_bytes += writer_.stream_frame(packet).size();
    if (!is_open()) return;
    if (recording_) recording_->packet(packet);
    if (!session_->send_packet(packet)) side_->packetizer()->announce();
}

// The time up to which everything can be done already: what is later may depend on samples that are under
// way.
TimePoint CoprocessorNode::allowed() const {
    if (!lockstep_) return pacer_->scene_time(clock_());
    if (!is_open()) return TimePoint::min();
    // The queue is sent first: however slowly the hand reads, it holds little more than this.
    if (session_->queued_bytes() >= LinkOptions{}.queue_bytes) return at_;
    if (follows_hand_) return peer_at_;
    return side_->table() && side_->table()->starving() ? at_ : std::max(peer_at_, scene_start) + lead;
}

Duration CoprocessorNode::behind(TimePoint due) const {
    return pacer_ ? pacer_->lag(due, clock_()) : Duration::zero();
}

// Returns when the next thing is due, as far as that depends on the clock.
MonotonicTime CoprocessorNode::do_what_is_due() {
    while (started_ && !stopping_) {
        const Due due = side_->next();
        const TimePoint until = std::min(due.time, end_);
        // A scan at the end itself would change nothing before it.
        const bool over = due.time > end_ || (due.time == end_ && due.kind == Kind::scan);
        if (over && (lockstep_ || pacer_->scene_time(clock_()) >= end_)) {
            finish_scene();
            break;
        }
        if (over || due.time > allowed()) return pacer_ ? pacer_->wall(until) : MonotonicTime::max();
        if (!do_next(behind(due.time))) break;
        if (pacer_) pacer_->did(due.time, clock_());
        at_ = due.time;
        if (lockstep_ && due.kind == Kind::packet_deadline) tell_progress();
    }
    return MonotonicTime::max();
}

bool CoprocessorNode::do_next(Duration behind) {
    try {
        const Result<void> done = side_->do_next(output_, behind);
        if (!done) fail(done.error().text);
        return done.has_value();
    } catch (const SpikeStormError& storm) {
        fail(storm.what());
        return false;
    }
}

bool CoprocessorNode::finish(TimePoint end) {
    try {
        side_->finish(end, output_);
        return true;
    } catch (const SpikeStormError& storm) {
        fail(storm.what());
        return false;
    }
}

// Until the next deadline no further packet will end.
void CoprocessorNode::tell_progress() {
    if (is_open()) session_->send_clock(side_->deadline() - Duration(1));
}

void CoprocessorNode::finish_scene() {
    if (!finish(end_)) return;
    at_ = end_;
    if (lockstep_ && is_open()) session_->send_clock(at_);
    stop(proto::END_OF_SCENE, "");
}

void CoprocessorNode::stop(proto::ByeReason reason, const std::string& text) {
    if (std::exchange(stopping_, true)) return;
    if (!is_open()) {
        done_ = true;
        return;
    }
    proto::Bye last = bye(reason);
    last.set_text(text);
    if (recording_) recording_->bye(last);
    session_->say_bye(last);
}

proto::Bye CoprocessorNode::bye(proto::ByeReason reason) const {
    proto::Bye bye;
    bye.set_reason(reason);
    bye.set_time_ns((at_ - scene_start).count());
    bye.set_packets(side_->packetizer()->packets());
    bye.set_events(side_->packetizer()->events());
    return bye;
}

void CoprocessorNode::fail(const std::string& text) {
    if (!failure_) failure_ = text;
    stop(proto::FAILURE, text);
}

CoprocessorNode::Report CoprocessorNode::report() const {
    Report report = report_;
    if (session_) report.link.add(*session_);
    return report;
}

}  // namespace afferent
