// afferent hand: the controller's side of a scene as a process of its own.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/file_link.hpp"
#include "afferent/apps/hello.hpp"
#include "afferent/apps/pacer.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/side_options.hpp"
#include "afferent/apps/side_summary.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hand_side.hpp"

namespace afferent {
namespace {

constexpr auto status_period = std::chrono::milliseconds(50);

// Of the places of a scene where a hand begins anew, how many are drawn.
constexpr std::size_t most_pictures = 10;

// What has been received, over all sessions.
void add(PacketCounts& sum, const PacketCounts& more) {
    sum.packets += more.packets;
    sum.events += more.events;
    sum.gaps += more.gaps;
    sum.lost_events += more.lost_events;
    sum.refused += more.refused;
    sum.late += more.late;
    sum.stale += more.stale;
}

const char* name(GripState state) {
    return state == GripState::safe ? "safe" : state == GripState::frozen ? "frozen" : "operating";
}

class HandProcess final : public HandClient {
  public:
    explicit HandProcess(const SideOptions& options)
        : options_(options),
          scene_(options.scene.read()),
          has_samples_(hand_has_samples(scene_)),
          patience_(from_seconds(scene_.description().link().connect_s())),
          listener_(value_or_fail(
              open_listener(loop_.io(), address_of(scene_, LinkSide::hand, options.lockstep)))) {
        start_side();
        if (!options_.record.empty())
            recording_ =
                value_or_fail(HandRecording::create(options_.record, scene_, proto::HAND, side_.get()));
    }

    void run() {
        listener_->start([this](std::unique_ptr<Link> link) {
            session_ = std::make_unique<HandSession>(std::move(link), make_hello(scene_, options_.lockstep),
                                                     *this, session_limits(options_.lockstep));
            session_->start();
        });
        std::cerr << "waiting for the coprocessor at " << text(listener_->address()) << '\n';
        alone_since_ = Pacer::Clock::now();
        loop_.run([this] { return pump(); }, [this] { look_after(); });
        Result<void> recorded =
            recording_ ? recording_->close(at_, side_->next_step()) : Result<void>(success());
        const Summary summary = summarise();
        recorder_->close(summary);
        recorders_.push_back(std::move(recorder_));
        for (const auto& recorder : recorders_)
            if (const auto undrawn = recorder->draw_picture()) std::cerr << *undrawn << '\n';
        print(summary, options_.json);
        session_.reset();
        value_or_fail(std::move(recorded));
        if (failure_) throw Failure(*failure_);
        if (interrupted()) throw Interrupted();
    }

  private:
    TimePoint end_of_scene() const { return scene_start + scene_.duration(); }

    void start_side() {
        if (recorder_) {
            recorder_->close(summarise());
            // Drawn in the end: it takes so long that the coprocessor would take us for gone.
            if (recorders_.size() < most_pictures) recorders_.push_back(std::move(recorder_));
        }
        side_ = value_or_fail(HandSide::open(scene_));
        recorder_ = std::make_unique<Recorder>(scene_, session_folder(options_.out, ++starts_),
                                               Recorder::Sides{.coprocessor = false, .hand = true});
    }

    bool open() const { return session_ && session_->state() == Session::State::open; }

    // HandClient
    void welcomed(const proto::Hello& hello) override {
        in_session_ = true;
        before_session_ = side_->next_step();
        if (recording_) recording_->hello(hello, before_session_);
        std::cerr << "the coprocessor is there\n";
        ++sessions_;
        clock_ = TimePoint::min();
        told_ = scene_start;
        if (!has_samples_) {
            // The coprocessor's clock tells where in the scene it is.
            if (sessions_ > 1) start_side();
            started_ = false;
            return;
        }
        if (sessions_ == 1) {
            begin(scene_start);
        } else {
            side_->restart(at_);
            if (recording_) recording_->begin(at_, false, before_session_);
        }
        clock_ = at_;
        send_clock(at_);
    }

    void received(const Reception& reception) override {
        recorder_->events(reception.events);
        // The coprocessor's clock comes before its packets, unless it was lost.
        if (!started_ && !has_samples_) begin_with(reception.known.begin);
        // Spans that the hand has not come near to cannot have been measured.
        if (!options_.lockstep && started_ && reception.known.end > pacer_->now() + 1s)
            return fail("the coprocessor reports " + std::to_string(seconds(reception.known.end)) +
                        " s, which is still to come");
        stale_ = reception.stale;
        if (!started_ || !side_->receive(reception)) return;
        if (!stale_) session_->receiver().count_late();
        late_at_ = side_->next_step();
    }

    void packet(const proto::Envelope& packet) override {
        if (recording_) recording_->packet(packet, late_at_, std::exchange(stale_, false));
        late_at_.reset();
    }

    Duration age(TimePoint time) const override {
        return options_.lockstep || !started_ ? Duration::zero() : pacer_->now() - time;
    }

    void clock(TimePoint time) override {
        if (!started_ && !has_samples_) begin_with(time);
        clock_ = std::max(clock_, time);
    }

    proto::Bye answer_bye(const proto::Bye&) override {
        proto::Bye bye;
        bye.set_time_ns((at_ - scene_start).count());
        return bye;
    }

    void ended(const SessionEnd& end) override {
        ended_totals_.add(*session_);
        add(ended_counts_, session_->receiver_counts());
        if (recording_ && end.bye && in_session_) recording_->bye(*end.bye, late_at_);
        late_at_.reset();
        in_session_ = false;
        watchdog_ = started_ ? std::optional(session_->watchdog()) : std::nullopt;
        session_.reset();
        alone_since_ = Pacer::Clock::now();
        std::cerr << (end.complete ? "the session has ended: " : "the session has broken off: ") << end.reason
                  << '\n';
        if (stopping_) return loop_.stop();
        if (!end.complete) {
            if (sessions_ > 0) ++broken_sessions_;
            return;  // and wait for the next
        }
        if (end.bye && end.bye->reason() == proto::END_OF_SCENE) {
            // What is left of the scene depends on nobody else.
            ended_ = true;
            clock_ = end_of_scene();
        } else {
            stopping_ = true;
            loop_.stop();
        }
    }

    // Where the coprocessor says that it is.
    void begin_with(TimePoint time) {
        if (time < scene_start || time > end_of_scene())
            return fail("the coprocessor is at " + std::to_string(seconds(time)) +
                        " s, outside of the scene");
        begin(time);
    }

    void begin(TimePoint time) {
        side_->begin_at(time);
        if (recording_) recording_->begin(time, true, before_session_);
        at_ = time;
        started_ = true;
        if (!options_.lockstep) pacer_.emplace(Pacer::Clock::now() - (time - scene_start));
    }

    void send_clock(TimePoint time) {
        told_ = time;
        session_->send_clock(time);
    }

    void send_samples(const Scan& scan) {
        proto::Samples& samples = *feed_.mutable_samples();
        samples.set_time_ns((scan.time - scene_start).count());
        samples.set_first(scan.first);
        samples.mutable_force_n()->Assign(scan.forces_n.begin(), scan.forces_n.end());
        feed_bytes_ += writer_.stream_frame(feed_).size();
        if (open()) session_->send_samples(samples);
    }

    // Until when the side may step: what comes later may depend on packets that are still to come.
    TimePoint allowed() const {
        if (!started_ || stopping_) return TimePoint::min();
        if (!options_.lockstep) return pacer_->now();
        if (ended_) return end_of_scene();
        if (!open() || clock_ == TimePoint::min()) return TimePoint::min();
        return clock_ + link_timing(scene_.description().link()).delivery;
    }

    GripState state() {
        if (options_.lockstep || ended_) return GripState::operating;
        if (open()) return session_->grip_state();
        return watchdog_ ? watchdog_->state(Pacer::Clock::now()) : GripState::operating;
    }

    Pacer::Clock::time_point pump() {
        while (started_ && !stopping_) {
            const Due due = side_->next();
            if (due.time >= end_of_scene()) return finish_scene(), wall_of(end_of_scene());
            if (due.time > allowed()) break;
            follow_state();
            const Result<void> stepped = side_->do_next([this](const ControllerStep& step) { on_step(step); },
                                                        [this](const Scan& scan) { send_samples(scan); });
            if (!stepped) {
                fail(stepped.error().text);
                break;
            }
            if (pacer_) pacer_->did(due.time);
            at_ = due.time;
            if (options_.lockstep && open()) tell_progress();
        }
        return started_ && !stopping_ ? wall_of(side_->next().time) : Pacer::Clock::time_point::max();
    }

    void on_step(const ControllerStep& step) {
        recorder_->step(step);
        if (recording_) recording_->step(step, *side_, open() ? &session_->receiver() : nullptr);
    }

    Pacer::Clock::time_point wall_of(TimePoint time) const {
        return pacer_ ? pacer_->wall(time) : Pacer::Clock::time_point::max();
    }

    // With samples: all before the next scan have been sent. Without: how far we have come, so that the
    // coprocessor does not run away.
    void tell_progress() {
        TimePoint told = at_;
        if (has_samples_) {
            const auto next = side_->source()->next();
            told = next ? next->time : end_of_scene();
        }
        if (told > told_ && (has_samples_ || told - told_ >= 5ms)) send_clock(told);
    }

    void finish_scene() {
        if (ended_ || (!options_.lockstep && pacer_->now() >= end_of_scene() + 1s)) {
            at_ = end_of_scene();
            stopping_ = true;
            if (open()) return say_bye(proto::END_OF_SCENE, "");
            loop_.stop();
        } else if (options_.lockstep && open() && told_ < end_of_scene()) {
            send_clock(end_of_scene());
        }
    }

    // Why the grip is safe, where it is.
    std::string reason() const {
        return open() ? session_->watchdog().reason() : watchdog_ ? watchdog_->reason() : "";
    }

    void follow_state() {
        const GripState now = state();
        if (now == last_state_) return;
        if (recording_) recording_->grip_state(now, reason(), side_->next_step());
        if (now == GripState::frozen) ++freezes_;
        if (now == GripState::safe) {
            ++safe_states_;
            std::cerr << "safe state: " << reason() << '\n';
        }
        last_state_ = now;
        side_->set_state(now);
    }

    void look_after() {
        if (session_) session_->tick();
        if (interrupted() && !stopping_) {
            stopping_ = true;
            if (!open()) return loop_.stop();
            say_bye(proto::INTERRUPTED, "interrupted");
        }
        const auto now = Pacer::Clock::now();
        if (open() && started_ && !stopping_ && now - told_status_ >= status_period) {
            told_status_ = now;
            send_status();
        }
        if (options_.lockstep && !session_ && !ended_ && sessions_ > 0 && now - alone_since_ > patience_)
            fail("the coprocessor has gone and has not come back in " +
                 std::to_string(Seconds(patience_).count()) + " s");
    }

    void send_status() {
        proto::Status status;
        status.set_time_ns((at_ - scene_start).count());
        status.set_position(session_->receiver().position());
        status.set_gain(side_->last_step().gain);
        status.set_state(last_state_ == GripState::safe     ? proto::SAFE
                         : last_state_ == GripState::frozen ? proto::FROZEN
                                                            : proto::OPERATING);
        status.set_reason(session_->watchdog().reason());
        session_->send_status(status);
    }

    void say_bye(proto::ByeReason reason, const std::string& text) {
        proto::Bye bye;
        bye.set_reason(reason);
        bye.set_text(text);
        bye.set_time_ns((at_ - scene_start).count());
        session_->say_bye(bye);
    }

    void fail(const std::string& text) {
        if (!failure_) failure_ = text;
        stopping_ = true;
        if (open()) return say_bye(proto::FAILURE, text);
        loop_.stop();
    }

    PacketCounts counts() const {
        PacketCounts counts = ended_counts_;
        if (session_) add(counts, session_->receiver_counts());
        return counts;
    }
    LinkTotals totals() const {
        LinkTotals totals = ended_totals_;
        if (session_) totals.add(*session_);
        totals.refused_frames += counts().refused;
        totals.forged_datagrams += listener_->strays();
        return totals;
    }

    // For `afferent link status`.
    Summary status() const {
        const PacketCounts counts = this->counts();
        const LinkTotals totals = this->totals();
        Summary status;
        add_standing(status, scene_, at_, session_.get(), sessions_);
        status["packets"] = counts.packets;
        status["events"] = counts.events;
        status["bytes"] = totals.bytes_received;
        status["gaps"] = counts.gaps;
        status["lost_events"] = counts.lost_events;
        status["late_packets"] = counts.late;
        status["stale_packets"] = counts.stale;
        status["checksum_failures"] = totals.checksum_failures;
        status["refused_frames"] = totals.refused_frames;
        status["forged_datagrams"] = totals.forged_datagrams;
        status["grip_state"] = name(last_state_);
        if (open() && !session_->watchdog().reason().empty())
            status["reason"] = session_->watchdog().reason();
        status["force_n"] = side_->last_step().estimate.force_n;
        status["sigma_n"] = side_->last_step().estimate.sigma_n;
        status["gain"] = side_->last_step().gain;
        return status;
    }

    Summary summarise() const {
        const PacketCounts counts = this->counts();
        Summary summary;
        add_progress(summary, "hand", scene_, at_);
        summary["sessions"] = sessions_;
        summary["broken_sessions"] = broken_sessions_;
        summary["refused_peers"] = listener_->refused_peers();
        summary["events"] = counts.events;
        summary["packets"] = counts.packets;
        summary["late_packets"] = counts.late;
        summary["stale_packets"] = counts.stale;
        summary["gaps"] = counts.gaps;
        summary["lost_events"] = counts.lost_events;
        totals().add_to(summary);
        // Of samples alone, as frames of a stream.
        summary["feed_bytes"] = feed_bytes_;
        summary["freezes"] = freezes_;
        summary["safe_states"] = safe_states_;
        summary["force_error_rms_n"] = recorder_->error().rms_n();
        summary["force_error_max_n"] = recorder_->error().max_n();
        add_pace(summary, pacer_);
        return summary;
    }

    const SideOptions& options_;
    Scene scene_;
    bool has_samples_;
    Duration patience_;
    EventLoop loop_;
    std::unique_ptr<HandSide> side_;
    std::unique_ptr<Recorder> recorder_;
    std::vector<std::unique_ptr<Recorder>> recorders_;  // whose picture is to be drawn still
    std::optional<HandRecording> recording_;
    std::uint64_t before_session_ = 0;      // the step that was due then
    std::optional<std::uint64_t> late_at_;  // the packet under way came too late for the steps before
    bool stale_ = false;                    // the packet at hand
    std::unique_ptr<Listener> listener_;
    std::unique_ptr<HandSession> session_;
    std::optional<Watchdog> watchdog_;  // of the last session
    proto::Envelope feed_;
    FrameWriter writer_;

    int starts_ = 0;
    bool in_session_ = false;  // since the hello
    bool started_ = false;
    bool ended_ = false;  // the coprocessor has told everything
    bool stopping_ = false;
    TimePoint at_ = scene_start;
    TimePoint clock_ = TimePoint::min();
    TimePoint told_ = scene_start;
    Pacer::Clock::time_point alone_since_;
    Pacer::Clock::time_point told_status_;
    GripState last_state_ = GripState::operating;
    std::optional<Pacer> pacer_;
    std::optional<std::string> failure_;

    StatusService service_{loop_.io(), scene_, "hand", [this] { return status(); }};

    LinkTotals ended_totals_;
    PacketCounts ended_counts_;
    std::uint64_t sessions_ = 0;
    std::uint64_t broken_sessions_ = 0;
    std::uint64_t feed_bytes_ = 0;
    std::uint64_t freezes_ = 0;
    std::uint64_t safe_states_ = 0;
};

}  // namespace

void add_hand_command(CLI::App& app) {
    const auto options = std::make_shared<SideOptions>();
    CLI::App* command = app.add_subcommand(
        "hand", "Run the hand's side of a scene: packets in from a coprocessor, EMG gain out");
    options->add_to(*command, "force.csv, emg.csv, summary.json and the picture");
    command->callback([options] {
        catch_interrupts();
        if (receive_from_file(*options)) return;
        HandProcess(*options).run();
    });
}

}  // namespace afferent
