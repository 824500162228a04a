#include "afferent/nodes/coprocessor_node.hpp"

#include <algorithm>
#include <utility>

#include "afferent/io/links/connector.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/printable.hpp"
#include "afferent/nodes/chip_line.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/coprocessor_report.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hello.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/pushed_source.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent {
namespace {

// How far samples of our own may run ahead of the hand in lockstep.
constexpr Duration lead = 200ms;

// How often a chip's line is looked at: a fraction of what a packet spans.
constexpr std::chrono::milliseconds look_at_chip_period{1};

// How far the time stamps of a hand may be ahead of our clock: more cannot be under way.
constexpr Duration plausible_lead = 10s;

// The pause before another attempt to open a session with a hand that does not accept one.
constexpr std::chrono::milliseconds pause_between_attempts{250};

void add(const CoprocessorNode::Report::Counts& counts, CoprocessorNode::Report::Counts& sum) {
    sum.samples += counts.samples;
    sum.events += counts.events;
    sum.packets += counts.packets;
    sum.raw_sample_bytes += counts.raw_sample_bytes;
    sum.packet_bytes += counts.packet_bytes;
}

class CoprocessorOnLink final : public CoprocessorNode, private CoprocessorClient {
  public:
    CoprocessorOnLink(const Plan& plan, std::unique_ptr<Connector> connector, bool lockstep,
                      Observer observer, MonotonicClock clock, std::unique_ptr<CoprocessorEnd> link_end,
                      std::unique_ptr<ChipDevice> chip);
    // Keeps the plan.
    void keep(std::unique_ptr<Plan> plan) { kept_plan_ = std::move(plan); }
    // To be called before start().
    Result<void> record(const std::filesystem::path& file);

    void start() override;
    std::optional<MonotonicTime> poll() override;
    Result<void> push(const Scan& scan) override;
    void interrupt() override;
    void fail(const std::string& text) override;
    Result<void> close() override { return recording_ ? recording_->close(at_) : Result<void>(success()); }
    const std::optional<std::string>& failure() const noexcept override { return failure_; }
    const Plan& plan() const noexcept override { return plan_; }
    TimePoint at() const noexcept override { return at_; }
    CoprocessorEnd& link_end() noexcept override { return *link_end_; }
    const CoprocessorEnd& link_end() const noexcept override { return *link_end_; }
    const CoprocessorSession* session() const noexcept override { return session_.get(); }
    const std::optional<Pacer>& pacer() const noexcept override { return pacer_; }
    Report report() const override;

  private:
    void welcomed() override;
    void samples(const proto::Samples& samples) override;
    void clock(TimePoint time) override;
    void status(const proto::Status& status) override;
    bool acknowledged(const proto::Acknowledgement& acknowledgement) override;
    std::optional<TimePoint> scene_time() const override;
    void ahead(Duration ahead) override;
    proto::Bye answer_bye(const proto::Bye&) override;
    void ended(const SessionEnd& end) override;

    bool is_open() const { return session_ && session_->state() == Session::State::open; }
    void connect();
    bool start_over();
    Report::Counts counts_since_begin() const;
    void begin(TimePoint time);
    bool plausible(TimePoint time) const;
    void close(const proto::Envelope& packet);
    void close_of_chip(const proto::Envelope& packet);
    void send(const proto::Envelope& packet);
    TimePoint allowed() const;
    void hear_chip();
    MonotonicTime do_what_is_due();
    // A scan that comes this long before its time leaves half of delivery_ms to its packet.
    Duration spare() const { return plan_.timing.delivery / 2; }
    // How long a span waits for the chip's packet of it, which in silence is its next heartbeat; then it is
    // told as unknown.
    Duration patience_with_chip() const { return plan_.timing.heartbeat + plan_.timing.span + spare(); }
    // How far the clock is past what was due at that time; 0 in lockstep.
    Duration behind(TimePoint due) const;
    bool do_next(Duration behind);
    bool finish(TimePoint end);
    void finish_scene();
    void tell_progress();
    void look_after();
    void stop(proto::ByeReason reason, const std::string& text);
    proto::Bye bye(proto::ByeReason reason) const;

    std::unique_ptr<Plan> kept_plan_;  // where the node was opened from a scene
    const Plan& plan_;
    Observer observer_;
    MonotonicClock clock_;
    bool lockstep_;
    bool follows_hand_;  // which has the samples
    Duration patience_;
    TimePoint end_;  // of the scene
    std::unique_ptr<CoprocessorEnd> link_end_;
    std::unique_ptr<ChipDevice> chip_;  // null where the neurons are emulated
    Observer end_observer_;
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
    std::optional<Duration> kept_ahead_;  // of the hand's clock, in this session
    MonotonicTime judged_at_{};           // when we last asked whether that is too far
    std::uint64_t scans_since_ = 0;
    std::uint64_t early_since_ = 0;  // of them
    MonotonicTime alone_since_{};
    MonotonicTime look_after_at_{};
    MonotonicTime connected_at_{};             // when the last attempt began
    std::optional<MonotonicTime> connect_at_;  // while no attempt is under way

    FrameWriter writer_;
    Report report_;  // `link` of the sessions that have ended, `counts` of the neurons' earlier times
    std::uint64_t packet_bytes_ = 0;  // since the neurons last began
};

CoprocessorOnLink::CoprocessorOnLink(const Plan& plan, std::unique_ptr<Connector> connector, bool lockstep,
                                     Observer observer, MonotonicClock clock,
                                     std::unique_ptr<CoprocessorEnd> link_end,
                                     std::unique_ptr<ChipDevice> chip)
    : plan_(plan),
      observer_(std::move(observer)),
      clock_(std::move(clock)),
      lockstep_(lockstep),
      follows_hand_(plan.samples_from == SamplesFrom::hand),
      patience_(from_seconds(plan.scene.link.connect_s)),
      end_(plan.end()),
      link_end_(std::move(link_end)),
      chip_(std::move(chip)),
      connector_(std::move(connector)) {
    end_observer_.events = observer_.events;
    end_observer_.scan = [this](const Scan& scan) { last_scan_ = std::max(last_scan_, scan.time); };
    end_observer_.packet = [this](const proto::Envelope& packet) { close(packet); };
}

void CoprocessorOnLink::start() {
    alone_since_ = look_after_at_ = clock_();
    connect();
}

void CoprocessorOnLink::connect() {
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

std::optional<MonotonicTime> CoprocessorOnLink::poll() {
    if (const MonotonicTime now = clock_(); now >= look_after_at_) {
        look_after();
        look_after_at_ = now + look_after_period;
    }
    if (chip_) hear_chip();
    MonotonicTime wake = do_what_is_due();
    if (done_) return std::nullopt;
    if (chip_) wake = std::min(wake, clock_() + look_at_chip_period);
    return std::min(wake, look_after_at_);
}

void CoprocessorOnLink::look_after() {
    if (session_) session_->poll();
    if (connect_at_ && !stopping_ && clock_() >= *connect_at_) connect();
}

void CoprocessorOnLink::interrupt() {
    if (stopping_) return;
    if (started_ && !finish(at_)) return;
    stop(proto::INTERRUPTED, "interrupted");
}

void CoprocessorOnLink::welcomed() {
    observer_.session("the hand is there");
    ++report_.sessions;
    welcomed_ = true;
    kept_ahead_.reset();
    judged_at_ = clock_();
    scans_since_ = early_since_ = 0;
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
    if (report_.sessions > 1 && link_end_->packetizer()) link_end_->packetizer()->announce();
}

bool CoprocessorOnLink::start_over() {
    observer_.starting_over();
    auto link_end = CoprocessorEnd::open(plan_);
    if (!link_end) {
        fail(link_end.error().text);
        return false;
    }
    add(counts_since_begin(), report_.counts);
    packet_bytes_ = 0;
    ++report_.times_begun;
    link_end_ = std::move(link_end.value());
    return true;
}

void CoprocessorOnLink::samples(const proto::Samples& samples) {
    const std::span<const double> forces_n(samples.force_n().data(),
                                           static_cast<std::size_t>(samples.force_n_size()));
    const TimePoint time = scene_start + Duration(samples.time_ns());
    if (!plausible(time))
        return fail("the hand sends samples from " + std::to_string(seconds(time)) + " s, far from " +
                    std::to_string(seconds(at_)) + " s");
    // The hand's clock comes before them, unless it was lost.
    if (follows_hand_ && !started_) begin(time);
    if (pacer_) {
        ++scans_since_;
        if (-pacer_->lag(time, clock_()) > spare()) ++early_since_;
    }
    link_end_->push({time, samples.first(), forces_n}, end_observer_, behind(link_end_->next().time));
}

bool CoprocessorOnLink::plausible(TimePoint time) const {
    return time >= scene_start && time <= end_ && (lockstep_ || !started_ || time < at_ + plausible_lead);
}

void CoprocessorOnLink::clock(TimePoint time) {
    if (follows_hand_ && !started_) {
        if (time < scene_start || time > end_) return fail("the hand sends a clock outside of the scene");
        begin(time);
    }
    peer_at_ = std::max(peer_at_, time);
}

void CoprocessorOnLink::status(const proto::Status& status) {
    report_.hand_gain = status.gain();
    if (status.needs_session())
        session_->break_off("the hand is safe until another session: " + printable(status.reason()));
}

bool CoprocessorOnLink::acknowledged(const proto::Acknowledgement& acknowledgement) {
    return link_end_->packetizer() && link_end_->packetizer()->acknowledge(acknowledgement);
}

std::optional<TimePoint> CoprocessorOnLink::scene_time() const {
    return pacer_ && started_ ? std::optional(pacer_->scene_time(clock_())) : std::nullopt;
}

// Samples arrive with a delay, and our clock began behind the hand's by that delay. It keeps that distance.
// Where the first message was held up, that is too far: nearly all scans then come early, and it comes
// nearer.
void CoprocessorOnLink::ahead(Duration ahead) {
    if (!follows_hand_ || !pacer_) return;
    const MonotonicTime now = clock_();
    if (!kept_ahead_) kept_ahead_ = ahead;
    if (now - judged_at_ >= 1s) {
        // By less than what they are early by, since our clock follows only in a second or two.
        if (20 * early_since_ > 19 * scans_since_) *kept_ahead_ += spare() / 2;
        judged_at_ = now;
        scans_since_ = early_since_ = 0;
    }
    pacer_->steer(now, *kept_ahead_ - ahead);
}

proto::Bye CoprocessorOnLink::answer_bye(const proto::Bye&) {
    const proto::Bye last = bye(proto::END_OF_SCENE);
    if (recording_) recording_->bye(last);
    return last;
}

void CoprocessorOnLink::ended(const SessionEnd& end) {
    report_.link.add(*session_);
    session_.reset();
    const bool was_welcome = std::exchange(welcomed_, false);
    // In real time, a session that the hand gives up may be followed by another.
    const bool given_up = !lockstep_ && end.bye && end.bye->reason() == proto::FAILURE;
    const bool over = end.complete && !given_up;
    const std::string told = (over ? "the session has ended: " : "the session has broken off: ") + end.reason;
    // A hand that has another coprocessor turns us away four times a second: that is told once.
    if (told != last_told_ || was_welcome) observer_.session(told);
    last_told_ = told;
    if (over && end.bye && end.bye->reason() != proto::END_OF_SCENE && !stopping_)
        ++report_.interrupted_sessions;
    if (over || stopping_) {
        stopping_ = done_ = true;
        return;
    }
    if (pacer_) pacer_->steer(clock_(), std::nullopt);
    if (was_welcome) {
        ++report_.broken_sessions;
        alone_since_ = clock_();
        // If the hand ends one session after another, the next attempt waits.
        if (alone_since_ - connected_at_ >= pause_between_attempts) return connect();
    }
    // Ends that do not fit now will not fit later. But a hand may have another coprocessor for a while, or
    // too many others that have only connected.
    const bool hopeless = !was_welcome && !end.unanswered;
    if (hopeless || clock_() - alone_since_ > patience_) return fail(end.reason);
    connect_at_ = clock_() + pause_between_attempts;
}

void CoprocessorOnLink::begin(TimePoint time) {
    link_end_->begin_at(time);
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
void CoprocessorOnLink::close(const proto::Envelope& packet) {
    if (chip_) return close_of_chip(packet);
    const bool silent = !lockstep_ && link_end_->deadline() - last_scan_ > plan_.timing.freeze;
    const bool skipping = link_end_->overdue() && !link_end_->overdue()->empty();
    if (!silent || !(link_end_->awaits_samples() || skipping)) return send(packet);
    marked_ = packet;
    marked_.set_no_samples_since_ns((last_scan_ - scene_start).count());
    send(marked_);
}

// Where a part of the packet's time is unknown, the packet is marked, and the hand receives it as a gap.
void CoprocessorOnLink::close_of_chip(const proto::Envelope& packet) {
    const TimePoint end = link_end_->deadline();
    const ChipReader& chip = *link_end_->chip();
    if (chip.knows(end - spans_of(packet, *plan_.packets) * plan_.packets->span, end)) return send(packet);
    marked_ = packet;
    marked_.set_no_samples_since_ns((std::min(chip.known_until(), end) - scene_start).count());
    send(marked_);
}

void CoprocessorOnLink::send(const proto::Envelope& packet) {
    packet_bytes_ += writer_.stream_frame(packet).size();
    if (!is_open()) return;
    if (recording_) recording_->packet(packet);
    if (!session_->send_packet(packet)) link_end_->packetizer()->announce();
}

// The time up to which everything can be done already: what is later may depend on samples that are under
// way.
TimePoint CoprocessorOnLink::allowed() const {
    if (!lockstep_) {
        const TimePoint now = pacer_->scene_time(clock_());
        // A span whose packet is late waits for it, as long as its own packet is in time then.
        return chip_ ? std::max(std::min(now, link_end_->chip()->known_until()), now - patience_with_chip())
                     : now;
    }
    if (!is_open()) return TimePoint::min();
    // The queue is sent first: however slowly the hand reads, it holds little more than this.
    if (session_->queued_bytes() >= LinkOptions{}.queue_bytes) return at_;
    if (follows_hand_) return peer_at_;
    return link_end_->table() && link_end_->table()->starving() ? at_
                                                                : std::max(peer_at_, scene_start) + lead;
}

Duration CoprocessorOnLink::behind(TimePoint due) const {
    return pacer_ ? pacer_->lag(due, clock_()) : Duration::zero();
}

void CoprocessorOnLink::hear_chip() {
    while (const ChipBytes* const bytes = chip_->next())
        // Before the neurons' time has begun, a chip is not followed.
        if (started_) link_end_->chip()->read(bytes->at, pacer_->scene_time(bytes->at), bytes->bytes);
    if (const auto ahead = link_end_->chip()->clock_ahead()) pacer_->steer(clock_(), *ahead);
    while (auto note = chip_->next_note()) observer_.session(*note);
    while (auto note = link_end_->chip()->next_note()) observer_.session(*note);
}

// Returns when the next thing is due, as far as that depends on the clock.
MonotonicTime CoprocessorOnLink::do_what_is_due() {
    while (started_ && !stopping_) {
        const Due due = link_end_->next();
        const TimePoint until = std::min(due.time, end_);
        // A scan at the end itself would change nothing before it.
        const bool over = due.time > end_ || (due.time == end_ && due.kind == Kind::scan);
        const TimePoint allowed = this->allowed();
        if (over && (lockstep_ || allowed >= end_)) {
            finish_scene();
            break;
        }
        if (due.time > allowed)
            return pacer_ ? pacer_->wall(chip_ ? until + patience_with_chip() : until) : MonotonicTime::max();
        if (!do_next(behind(due.time))) break;
        // A span that waits for its chip is not late by our doing.
        if (pacer_ && !chip_) pacer_->did(due.time, clock_());
        at_ = due.time;
        if (lockstep_ && due.kind == Kind::packet_deadline) tell_progress();
    }
    return MonotonicTime::max();
}

bool CoprocessorOnLink::do_next(Duration behind) {
    try {
        const Result<void> done = link_end_->do_next(end_observer_, behind);
        if (!done) fail(done.error().text);
        return done.has_value();
    } catch (const SpikeStormError& storm) {
        fail(storm.what());
        return false;
    }
}

bool CoprocessorOnLink::finish(TimePoint end) {
    try {
        link_end_->finish(end, end_observer_);
        return true;
    } catch (const SpikeStormError& storm) {
        fail(storm.what());
        return false;
    }
}

// Until the next deadline no further packet will end.
void CoprocessorOnLink::tell_progress() {
    if (is_open()) session_->send_clock(link_end_->deadline() - Duration(1));
}

void CoprocessorOnLink::finish_scene() {
    if (!finish(end_)) return;
    at_ = end_;
    if (lockstep_ && is_open()) session_->send_clock(at_);
    stop(proto::END_OF_SCENE, "");
}

void CoprocessorOnLink::stop(proto::ByeReason reason, const std::string& text) {
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

proto::Bye CoprocessorOnLink::bye(proto::ByeReason reason) const {
    proto::Bye bye;
    bye.set_reason(reason);
    bye.set_time_ns((at_ - scene_start).count());
    bye.set_packets(link_end_->packetizer()->packets());
    bye.set_events(link_end_->packetizer()->events());
    return bye;
}

void CoprocessorOnLink::fail(const std::string& text) {
    if (!failure_) failure_ = text;
    stop(proto::FAILURE, text);
}

CoprocessorNode::Report CoprocessorOnLink::report() const {
    Report report = report_;
    if (session_) report.link.add(*session_);
    report.since_begin = counts_since_begin();
    add(report.since_begin, report.counts);
    return report;
}

CoprocessorNode::Report::Counts CoprocessorOnLink::counts_since_begin() const {
    return {.samples = link_end_->samples(),
            .events = link_end_->events(),
            .packets = link_end_->packetizer()->packets(),
            .raw_sample_bytes = link_end_->raw_sample_bytes(),
            .packet_bytes = packet_bytes_};
}

Result<void> CoprocessorOnLink::push(const Scan& scan) {
    if (!link_end_->pushed())
        return Error{Error::Kind::not_allowed, plan_.scene.file + ": its source is not pushed {}"};
    return link_end_->pushed()->push(scan);
}

Result<void> CoprocessorOnLink::record(const std::filesystem::path& file) {
    AFFERENT_TRY(recording, HandRecording::create(file, plan_, proto::COPROCESSOR, nullptr));
    recording_ = std::move(recording);
    return success();
}

Result<std::unique_ptr<CoprocessorOnLink>> open_on_link(
    const Plan& plan, std::unique_ptr<Connector> connector, const NodeOptions& options, Observer observer,
    MonotonicClock clock, CoprocessorNode::ReadInput standard_input, std::unique_ptr<ChipDevice> chip) {
    if (std::holds_alternative<scene::Chip>(plan.scene.source)) {
        if (options.lockstep)
            return Error{
                Error::Kind::not_allowed,
                plan.scene.file + ": source.chip has a clock of its own, and does not go in lockstep"};
        if (!chip) {
            AFFERENT_TRY(line, open_chip_line(plan));
            chip = std::move(line);
        }
    }
    AFFERENT_TRY(link_end, CoprocessorEnd::open(plan, std::move(standard_input)));
    auto node =
        std::make_unique<CoprocessorOnLink>(plan, std::move(connector), options.lockstep, std::move(observer),
                                            std::move(clock), std::move(link_end), std::move(chip));
    if (!options.record.empty()) {
        AFFERENT_TRY(node->record(options.record));
    }
    return node;
}

}  // namespace

Result<std::unique_ptr<CoprocessorNode>> CoprocessorNode::open(const Plan& plan,
                                                               std::unique_ptr<Connector> connector,
                                                               const NodeOptions& options, Observer observer,
                                                               MonotonicClock clock,
                                                               ReadInput standard_input) {
    AFFERENT_TRY(node, open_on_link(plan, std::move(connector), options, std::move(observer),
                                    std::move(clock), std::move(standard_input), {}));
    return std::unique_ptr<CoprocessorNode>(std::move(node));
}

Result<std::unique_ptr<CoprocessorNode>> CoprocessorNode::open(const Plan& plan,
                                                               std::unique_ptr<Connector> connector,
                                                               const NodeOptions& options, Observer observer,
                                                               MonotonicClock clock,
                                                               std::unique_ptr<ChipDevice> chip) {
    AFFERENT_TRY(node, open_on_link(plan, std::move(connector), options, std::move(observer),
                                    std::move(clock), {}, std::move(chip)));
    return std::unique_ptr<CoprocessorNode>(std::move(node));
}

Result<std::unique_ptr<CoprocessorNode>> CoprocessorNode::open(const Scene& scene,
                                                               boost::asio::io_context& io,
                                                               const NodeOptions& options,
                                                               Observer observer) {
    auto plan = std::make_unique<Plan>(make_plan(scene));
    AFFERENT_TRY(address, address_of(*plan, LinkEnd::coprocessor, options.lockstep));
    const auto patience =
        std::chrono::duration_cast<std::chrono::milliseconds>(from_seconds(plan->scene.link.connect_s));
    auto connector = make_connector(io, address, {.limit = patience}, link_options(*plan, options.lockstep));
    AFFERENT_TRY(node, open_on_link(*plan, std::move(connector), options, std::move(observer),
                                    std::chrono::steady_clock::now, {}, {}));
    node->keep(std::move(plan));
    return std::unique_ptr<CoprocessorNode>(std::move(node));
}

}  // namespace afferent
