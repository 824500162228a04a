// afferent coprocessor: the spiking side of a scene as a process of its own.
#include <CLI/CLI.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_loop.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/file_link.hpp"
#include "afferent/apps/hello.hpp"
#include "afferent/apps/pacer.hpp"
#include "afferent/apps/recorder.hpp"
#include "afferent/apps/side_options.hpp"
#include "afferent/apps/side_summary.hpp"
#include "afferent/apps/standard_input.hpp"
#include "afferent/apps/status_service.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/links/transports.hpp"
#include "afferent/nodes/coprocessor_side.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hand_side.hpp"
#include "afferent/runtime/spike_storm.hpp"

namespace afferent {
namespace {

// In lockstep, how far samples of our own may run ahead of the hand.
constexpr Duration lead = 200ms;

// Between two attempts at a hand that is there and does not take us.
constexpr std::chrono::milliseconds pause{250};

class CoprocessorProcess final : public CoprocessorClient {
  public:
    explicit CoprocessorProcess(const SideOptions& options)
        : options_(options),
          scene_(options.scene.read()),
          follows_hand_(hand_has_samples(scene_)),
          patience_(from_seconds(scene_.description().link().connect_s())),
          connector_(make_connector(loop_.io(), address_of(scene_, LinkSide::coprocessor, options.lockstep),
                                    {.limit = std::chrono::duration_cast<std::chrono::milliseconds>(
                                         from_seconds(scene_.description().link().connect_s()))})) {
        start_side();
        output_.events = [this](std::span<const Event> events) { recorder_->events(events); };
        output_.packet = [this](const proto::Envelope& packet) { send(packet); };
        if (!options_.record.empty())
            recording_ =
                value_or_fail(HandRecording::create(options_.record, scene_, proto::COPROCESSOR, nullptr));
    }

    void run() {
        alone_since_ = Pacer::Clock::now();
        connect();
        loop_.run([this] { return pump(); }, [this] { look_after(); });
        Result<void> recorded = recording_ ? recording_->close(at_) : Result<void>(success());
        const auto summary = summarise();
        session_.reset();
        recorder_->finish(summary);
        print(summary, options_.json);
        value_or_fail(std::move(recorded));
        if (failure_) throw Failure(*failure_);
        if (interrupted()) throw Interrupted();
    }

  private:
    TimePoint end_of_scene() const { return scene_start + scene_.duration(); }

    // Neurons at rest, at the beginning of what this side has to tell.
    void start_side() {
        const bool first = !side_;
        if (!first) recorder_->finish(summarise());
        side_ = value_or_fail(CoprocessorSide::open(scene_, blocking_standard_input()));
        input_ = feed_standard_input(loop_.io(), *side_, [this](const Error& error) { fail(error.text); });
        const auto folder = session_folder(options_.out, ++starts_);
        recorder_.emplace(scene_, folder, Recorder::Sides{.coprocessor = true, .hand = false});
    }

    void connect() {
        connector_->start([this](Result<std::unique_ptr<Link>> link) {
            if (!link) return fail(link.error().text);
            hello_ = make_hello(scene_, options_.lockstep);
            session_ = std::make_unique<CoprocessorSession>(std::move(link.value()), hello_, *this,
                                                            session_limits(options_.lockstep));
            session_->start();
        });
    }

    bool open() const { return session_ && session_->state() == Session::State::open; }

    // CoprocessorClient
    void welcomed() override {
        std::cerr << "the hand is there\n";
        ++sessions_;
        was_open_ = true;
        if (recording_) recording_->hello(hello_);
        if (follows_hand_) {
            // The hand's clock tells where in the scene we are; its samples were lost while it was away.
            if (sessions_ > 1) start_side();
            started_ = false;
            clock_ = TimePoint::min();
            return;
        }
        if (!started_)
            begin(scene_start);
        else if (recording_)
            recording_->begin(at_, false);
        session_->send_clock(at_);
        if (options_.lockstep) tell_progress();
        if (sessions_ > 1 && side_->packetizer()) side_->packetizer()->announce();
    }

    void samples(const proto::Samples& samples) override {
        const std::span<const double> forces_n(samples.force_n().data(),
                                               static_cast<std::size_t>(samples.force_n_size()));
        const TimePoint time = scene_start + Duration(samples.time_ns());
        if (!plausible(time))
            return fail_session("samples from " + std::to_string(seconds(time)) + " s, far from " +
                                std::to_string(seconds(at_)) + " s");
        // The hand's clock comes before them, unless it was lost.
        if (follows_hand_ && !started_) begin(time);
        side_->push({time, samples.first(), forces_n}, output_);
    }

    void clock(TimePoint time) override {
        if (follows_hand_ && !started_) {
            if (time < scene_start || time > end_of_scene())
                return fail_session("a clock outside of the scene");
            begin(time);
        }
        clock_ = std::max(clock_, time);
    }

    void status(const proto::Status& status) override { hand_gain_ = status.gain(); }

    proto::Bye answer_bye(const proto::Bye&) override {
        const proto::Bye last = bye(proto::END_OF_SCENE);
        if (recording_) recording_->bye(last);
        return last;
    }

    void ended(const SessionEnd& end) override {
        ended_totals_.add(*session_);
        session_.reset();
        const bool was_open = std::exchange(was_open_, false);
        const std::string told =
            (end.complete ? "the session has ended: " : "the session has broken off: ") + end.reason;
        if (told != last_told_ || was_open) std::cerr << told << '\n';
        last_told_ = told;
        if (end.complete || stopping_) return loop_.stop();
        if (was_open) {
            ++broken_sessions_;
            alone_since_ = Pacer::Clock::now();
            return connect();
        }
        // Refused at first: to try again would not change that. Later, another coprocessor may have the hand,
        // or our old session still.
        const bool hopeless = sessions_ == 0 && !end.unanswered;
        if (hopeless || Pacer::Clock::now() - alone_since_ > patience_) return fail(end.reason);
        again_.expires_after(pause);
        again_.async_wait([this](const boost::system::error_code& error) {
            if (!error) connect();
        });
    }

    // A peer's time stamps are believed within the packets that could be under way.
    bool plausible(TimePoint time) const {
        return time >= scene_start && time <= end_of_scene() &&
               (options_.lockstep || !started_ || time < at_ + 10s);
    }

    void begin(TimePoint time) {
        side_->begin_at(time);
        if (recording_) recording_->begin(time, sessions_ == 1);
        at_ = time;
        started_ = true;
        if (!options_.lockstep) return void(pacer_.emplace(Pacer::Clock::now() - (time - scene_start)));
        if (follows_hand_) tell_progress();
    }

    void send(const proto::Envelope& packet) {
        link_bytes_ += writer_.stream_frame(packet).size();
        if (!open()) return;
        if (recording_) recording_->packet(packet);
        if (!session_->send_packet(packet)) side_->packetizer()->announce();
    }

    // Until when the side may step: what comes later may depend on samples that are still to come.
    TimePoint allowed() {
        if (!started_ || stopping_) return TimePoint::min();
        if (!options_.lockstep) return pacer_->now();
        if (!open()) return TimePoint::min();
        if (follows_hand_) return clock_;
        return side_->table() && side_->table()->starving() ? at_ : std::max(clock_, scene_start) + lead;
    }

    Pacer::Clock::time_point pump() {
        while (started_ && !stopping_) {
            const Due due = side_->next();
            if (due.time > end_of_scene()) return finish_scene(), Pacer::Clock::now();
            if (due.time > allowed()) break;
            if (const Result<void> stepped = step(); !stepped) {
                fail(stepped.error().text);
                break;
            }
            if (pacer_) pacer_->did(due.time);
            at_ = due.time;
            if (options_.lockstep && due.kind == Kind::packet_deadline) tell_progress();
        }
        if (!started_ || stopping_ || !pacer_) return Pacer::Clock::time_point::max();
        return pacer_->wall(std::min(side_->next().time, end_of_scene()));
    }

    // No packet will end before the next deadline.
    void tell_progress() {
        if (open()) session_->send_clock(side_->deadline() - Duration(1));
    }

    Result<void> step() {
        try {
            return side_->do_next(output_);
        } catch (const SpikeStormError& storm) {
            return Error{Error::Kind::malformed, storm.what()};
        }
    }

    void finish_scene() {
        if (options_.lockstep || pacer_->now() >= end_of_scene()) {
            side_->finish(end_of_scene(), output_);
            at_ = end_of_scene();
            if (options_.lockstep && open()) session_->send_clock(at_);
            stop(proto::END_OF_SCENE, "");
        }
    }

    void look_after() {
        if (session_) session_->tick();
        if (interrupted() && !stopping_) {
            if (started_) side_->finish(at_, output_);
            stop(proto::INTERRUPTED, "interrupted");
        }
    }

    void stop(proto::ByeReason reason, const std::string& text) {
        stopping_ = true;
        if (!open()) return loop_.stop();
        proto::Bye last = bye(reason);
        last.set_text(text);
        if (recording_) recording_->bye(last);
        session_->say_bye(last);
    }

    proto::Bye bye(proto::ByeReason reason) const {
        proto::Bye bye;
        bye.set_reason(reason);
        bye.set_time_ns((at_ - scene_start).count());
        bye.set_packets(side_->packetizer()->packets());
        bye.set_events(side_->packetizer()->events());
        return bye;
    }

    void fail(const std::string& text) {
        if (!failure_) failure_ = text;
        stop(proto::FAILURE, text);
    }
    void fail_session(const std::string& text) { fail("the hand sends " + text); }

    LinkTotals totals() const {
        LinkTotals totals = ended_totals_;
        if (session_) totals.add(*session_);
        return totals;
    }

    // For `afferent link status`.
    Summary status() const {
        const LinkTotals totals = this->totals();
        Summary status;
        add_standing(status, scene_, at_, session_.get(), sessions_);
        status["samples"] = side_->samples();
        status["packets"] = side_->packetizer()->packets();
        status["events"] = side_->events();
        status["bytes"] = totals.bytes_sent;
        status["queued_bytes"] = session_ ? session_->queued_bytes() : 0;
        status["dropped_packets"] = totals.dropped_packets;
        status["bytes_received"] = totals.bytes_received;
        status["refused_frames"] = totals.refused_frames;
        status["hand_gain"] = hand_gain_;
        return status;
    }

    Summary summarise() const {
        const LinkTotals totals = this->totals();
        Summary summary;
        add_progress(summary, "coprocessor", scene_, at_);
        summary["sessions"] = sessions_;
        summary["broken_sessions"] = broken_sessions_;
        add_coprocessor(summary, *side_);
        summary["dropped_packets"] = totals.dropped_packets;
        // Of packets alone, as frames of a stream: what any transport adds is in bytes_sent.
        summary["link_bytes"] = link_bytes_;
        totals.add_to(summary);
        add_pace(summary, pacer_);
        return summary;
    }

    const SideOptions& options_;
    Scene scene_;
    bool follows_hand_;
    Duration patience_;
    EventLoop loop_;
    std::unique_ptr<CoprocessorSide> side_;
    std::shared_ptr<void> input_;
    CoprocessorSide::Output output_;
    std::optional<Recorder> recorder_;
    std::optional<HandRecording> recording_;
    std::unique_ptr<Connector> connector_;
    proto::Hello hello_;  // of the last session
    std::unique_ptr<CoprocessorSession> session_;
    FrameWriter writer_;

    int starts_ = 0;
    bool was_open_ = false;  // the session at hand
    std::string last_told_;
    boost::asio::steady_timer again_{loop_.io()};
    bool started_ = false;
    bool stopping_ = false;
    TimePoint at_ = scene_start;
    TimePoint clock_ = TimePoint::min();
    Pacer::Clock::time_point alone_since_;
    std::optional<Pacer> pacer_;
    std::optional<std::string> failure_;

    LinkTotals ended_totals_;
    std::uint64_t sessions_ = 0;
    std::uint64_t broken_sessions_ = 0;
    std::uint64_t link_bytes_ = 0;
    double hand_gain_ = std::numeric_limits<double>::quiet_NaN();
    StatusService service_{loop_.io(), scene_, "coprocessor", [this] { return status(); }};
};

}  // namespace

void add_coprocessor_command(CLI::App& app) {
    const auto options = std::make_shared<SideOptions>();
    CLI::App* command = app.add_subcommand(
        "coprocessor", "Run the spiking side of a scene: samples in, packets out to a hand");
    options->add_to(*command, "events.csv and summary.json");
    command->callback([options] {
        catch_interrupts();
        if (send_to_file(*options)) return;
        CoprocessorProcess(*options).run();
    });
}

}  // namespace afferent
