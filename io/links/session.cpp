#include "afferent/io/links/session.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "afferent/io/wire/printable.hpp"

namespace afferent {
namespace {

// Peers can send any number. 146 years is longer than any scene, and far from an overflow.
bool is_scene_time(std::int64_t time_ns) { return time_ns >= 0 && time_ns < std::int64_t{1} << 62; }

TimePoint scene_time(std::int64_t time_ns) { return scene_start + Duration(time_ns); }

proto::Envelope clock_message(TimePoint time) {
    proto::Envelope message;
    message.mutable_clock()->set_time_ns((time - scene_start).count());
    return message;
}

// In the peer's words, or in our own if it sent none.
std::string reason_of(const proto::Bye& bye) {
    if (!bye.text().empty()) return printable(bye.text());
    switch (bye.reason()) {
        case proto::INTERRUPTED:
            return "the peer was interrupted";
        case proto::FAILURE:
            return "the peer has failed";
        default:
            return "this is the end of the scene";
    }
}

Duration milliseconds(double count) { return Duration(std::llround(count * 1e6)); }

// How often the coprocessor's clock is asked for while it is unknown, and afterwards.
constexpr std::chrono::milliseconds first_probes{20};
constexpr std::chrono::milliseconds probe_period{250};

// A packet is stamped no later than its coprocessor's clock, apart from its own span when a scene is cut
// short, and the error of our estimate.
constexpr Duration most_ahead = 100ms;

}  // namespace

Session::Session(std::unique_ptr<Link> link, const SessionLimits& limits, MonotonicClock clock)
    : link_(std::move(link)), limits_(limits), clock_(std::move(clock)) {}

void Session::start() {
    deadline_ = now() + limits_.handshake;
    repeat_at_ = now() + limits_.repetition;
    window_begin_ = now();
    link_->start({.message = [this](const proto::Envelope& message) { receive(message); },
                  .bad_frame = [this](const Error& error) { hear_bad_frame(error.text); },
                  .closed = [this](const Error& error) { hear_of_end(error); }});
    on_start();
}

void Session::poll() {
    if (state_ == State::handshake && now() >= deadline_)
        return end({.reason = "the peer has not finished the handshake within " +
                              std::to_string(limits_.handshake.count()) + " ms",
                    .unanswered = true});
    if (state_ == State::farewell && now() >= deadline_)
        return answer_ ? part() : fail("the peer has not said bye");
    if (state_ == State::open && ordered() && limits_.silence.count() > 0 &&
        now() - last_heard_ > limits_.silence)
        return fail("the peer has been silent for " + std::to_string(limits_.silence.count()) + " ms");
    if (state_ == State::open) return on_poll();
    if (ordered() || now() < repeat_at_) return;
    repeat_at_ = now() + limits_.repetition;
    if (state_ == State::handshake) repeat_handshake();
    if (state_ == State::farewell) send_bye(last_word_);
}

void Session::hear_of_end(const Error& error) {
    if (answer_) return part();
    end({.reason = error.text,
         .unanswered = state_ == State::handshake && error.kind != Error::Kind::not_allowed});
}

void Session::say_bye(const proto::Bye& bye) {
    if (state_ == State::farewell || state_ == State::ended) return;
    send_bye(bye);
    last_word_ = bye;
    state_ = State::farewell;
    deadline_ = now() + limits_.farewell;
    repeat_at_ = now() + limits_.repetition;
}

void Session::send_bye(const proto::Bye& bye) {
    proto::Envelope message;
    *message.mutable_bye() = bye;
    send(message);
}

void Session::send_last_bye(const proto::Bye& bye) {
    for (int i = 0; i < (ordered() ? 1 : last_words); ++i) send_bye(bye);
}

void Session::break_off(const std::string& reason) {
    if (state_ != State::open) return;
    proto::Bye bye;
    bye.set_reason(proto::FAILURE);
    bye.set_text(reason);
    send_last_bye(bye);
    fail(reason);
}

void Session::receive(const proto::Envelope& message) {
    if (state_ == State::ended) return;
    last_heard_ = now();
    if (are_too_many(message))
        refuse("more messages than a session has");
    else if (message.has_bye())
        receive_bye(message.bye());
    else if (message.has_clock() && !is_scene_time(message.clock().time_ns()))
        refuse("clock: the time is out of range");
    else
        on_message(message);
}

void Session::receive_bye(const proto::Bye& bye) {
    if (!is_scene_time(bye.time_ns())) return refuse("bye: the time is out of range");
    if (state_ == State::handshake) {
        // Where messages may be late, this bye belongs to an earlier session.
        if (ordered()) refuse("the peer says bye before there is a session");
        return;
    }
    if (!answer_) on_bye(bye);
    if (state_ == State::open) {
        send_last_bye(answer_bye(bye));
        return end({.complete = true, .reason = reason_of(bye), .bye = bye});
    }
    if (!answer_) deadline_ = std::min(deadline_, now() + limits_.copies);
    answer_ = bye;
    if (++answers_ == (ordered() ? 1 : last_words)) part();
}

// The reason is that of the end that said bye first.
void Session::part() { end({.complete = true, .reason = reason_of(last_word_), .bye = answer_}); }

void Session::refuse(const std::string& text) {
    ++refused_messages_;
    count_bad_frame(text);
}

void Session::hear_bad_frame(const std::string& text) {
    if (needs_every_frame_ && state_ != State::handshake)
        fail("a frame is lost that later packets refer to: " + text);
    else
        count_bad_frame(text);
}

void Session::count_bad_frame(const std::string& text) {
    last_refusal_ = text;
    if (state_ == State::handshake) {
        if (ordered()) fail(text);
        return;
    }
    begin_window();
    if (++bad_in_window_ > limits_.bad_frames) fail("too many bad frames, the last: " + text);
}

// Packets, what acknowledges them, and samples are limited by the time that they cover.
bool Session::are_too_many(const proto::Envelope& message) {
    if (limits_.messages == 0 || is_packet(message) || message.has_samples() ||
        message.has_acknowledgement() || message.has_bye())
        return false;
    begin_window();
    return ++messages_in_window_ > limits_.messages;
}

void Session::begin_window() {
    if (now() - window_begin_ <= limits_.bad_frames_window) return;
    window_begin_ = now();
    bad_in_window_ = messages_in_window_ = 0;
}

void Session::end(SessionEnd end) {
    if (state_ == State::ended) return;
    state_ = State::ended;
    link_->close();
    on_end(end);
}

CoprocessorSession::CoprocessorSession(std::unique_ptr<Link> link, const proto::Hello& hello,
                                       CoprocessorClient& client, const SessionLimits& limits,
                                       MonotonicClock clock)
    : Session(std::move(link), limits, std::move(clock)), hello_(hello), client_(client) {}

void CoprocessorSession::send_clock(TimePoint time) { send(clock_message(time)); }

void CoprocessorSession::send_hello() {
    proto::Envelope message;
    *message.mutable_hello() = hello_;
    send(message);
}

void CoprocessorSession::receive_answer(const proto::Answer& answer) {
    // It answers a hello of an earlier session, or a repeated one of ours.
    if (!ordered() && (answer.nonce() != hello_.nonce() || state() != State::handshake)) return;
    if (state() != State::handshake) return refuse("a second answer");
    if (!answer.welcome())
        return end(
            {.reason = "the hand refuses: " + printable(answer.refusal()), .unanswered = answer.busy()});
    if (answer.nonce() != hello_.nonce()) return fail("the hand answers another hello than ours");
    open();
    client_.welcomed();
}

void CoprocessorSession::on_message(const proto::Envelope& message) {
    if (message.has_answer()) {
        receive_answer(message.answer());
    } else if (state() == State::handshake) {
        // The answer may have been lost, or overtaken.
        if (ordered()) refuse("the hand sends something before its answer to our hello");
    } else if (message.has_status()) {
        client_.status(message.status());
    } else if (message.has_acknowledgement()) {
        if (!client_.acknowledged(message.acknowledgement()))
            refuse("an acknowledgement of packets that have not been sent");
    } else if (message.has_samples()) {
        if (!is_scene_time(message.samples().time_ns())) return refuse("samples: the time is out of range");
        const auto& forces = message.samples().force_n();
        if (!std::all_of(forces.begin(), forces.end(), [](double force) { return std::isfinite(force); }))
            return refuse("samples: a force is not finite");
        client_.samples(message.samples());
    } else if (message.has_clock()) {
        client_.clock(scene_time(message.clock().time_ns()));
    } else if (message.has_probe()) {
        receive_probe(message.probe());
    } else {
        refuse("a message out of turn, or one that only a coprocessor sends");
    }
}

void CoprocessorSession::receive_probe(const proto::Probe& probe) {
    // Two scene times are never further apart, and differences of two such values do not overflow.
    constexpr std::int64_t furthest = std::int64_t{1} << 61;
    if (probe.ahead_ns() > furthest || probe.ahead_ns() < -furthest)
        return refuse("probe: the clocks cannot be so far apart");
    if (const auto time = client_.scene_time()) {
        proto::Envelope echo;
        echo.mutable_echo()->set_number(probe.number());
        echo.mutable_echo()->set_time_ns((*time - scene_start).count());
        send(echo);
    }
    if (probe.has_ahead_ns()) client_.ahead(Duration(probe.ahead_ns()));
}

HandSession::HandSession(std::unique_ptr<Link> link, const proto::Hello& expected, HandClient& client,
                         const SessionLimits& limits, MonotonicClock clock)
    : Session(std::move(link), limits, std::move(clock)),
      expected_(expected),
      client_(client),
      order_(ordered() ? Duration::zero() : limits.overtaking) {}

void HandSession::send_status(const proto::Status& status) {
    proto::Status& told = *message_.mutable_status();
    told = status;
    if (peer_clock_.known()) {
        told.set_round_trip_us(static_cast<std::uint32_t>(peer_clock_.round_trip() / 1us));
        told.set_drift_ppm(static_cast<std::int32_t>(std::lround(peer_clock_.drift() * 1e6)));
        if (const auto ahead = this->ahead()) told.set_ahead_us(*ahead / 1us);
    }
    send(message_);
}

void HandSession::send_samples(const proto::Samples& samples) {
    *message_.mutable_samples() = samples;
    send(message_);
}

void HandSession::send_clock(TimePoint time) { send(clock_message(time)); }

void HandSession::on_message(const proto::Envelope& message) {
    if (state() == State::handshake) {
        if (message.has_hello())
            answer(message.hello());
        else if (ordered())
            refuse("the coprocessor sends something before its hello");
    } else if (is_packet(message)) {
        receive(message);
    } else if (message.has_clock()) {
        client_.clock(scene_time(message.clock().time_ns()));
    } else if (message.has_echo()) {
        receive(message.echo());
    } else if (message.has_hello() && !ordered()) {
        hear_again(message.hello());
    } else {
        refuse("a message out of turn, or one that only a hand sends");
    }
}

void HandSession::answer(const proto::Hello& hello) {
    proto::Envelope reply;
    reply.mutable_answer()->set_nonce(hello.nonce());
    std::optional<std::string> refusal = disagreement(hello, expected_);
    const Result<PacketLayout> layout = layout_of(hello);
    if (!refusal && !layout) refusal = layout.error().text;
    if (refusal) {
        reply.mutable_answer()->set_refusal(*refusal);
        send(reply);
        return fail("the coprocessor was refused: " + printable(*refusal));
    }
    intake_.emplace(layout.value(), milliseconds(hello.stale_ms()));
    nonce_ = hello.nonce();
    span_ = layout.value().span;
    if (ordered() && layout.value().encoding == Encoding::predicted) need_every_frame();
    welcome();
    open();
    client_.welcomed(hello);
    on_poll();
}

void HandSession::welcome() {
    proto::Envelope reply;
    reply.mutable_answer()->set_nonce(nonce_);
    reply.mutable_answer()->set_welcome(true);
    send(reply);
}

// Our answer was lost; or the coprocessor was restarted, and its next hello opens a session.
void HandSession::hear_again(const proto::Hello& hello) {
    if (hello.nonce() == nonce_)
        welcome();
    else
        fail("the coprocessor has started again");
}

void HandSession::receive(const proto::Envelope& packet) {
    if (order_.hold(packet, intake_->receiver(), now()) || receive_next(packet, now())) receive_held();
}

void HandSession::receive_held() {
    while (const PacketOrder::Held* next = intake_ ? order_.next(intake_->receiver(), now()) : nullptr)
        if (!receive_next(next->packet, next->arrived)) return;
}

// At the end of the session no packet waits any longer, and those that are refused are only counted.
void HandSession::take_all_held() {
    if (!intake_) return;
    while (const auto* next = order_.next(intake_->receiver(), MonotonicTime::max()))
        if (const auto taken = take(next->packet, next->arrived);
            !taken && taken.error().kind != Error::Kind::out_of_order)
            count_refused();
}

bool HandSession::receive_next(const proto::Envelope& packet, MonotonicTime arrived) {
    const Result<Reception> taken = take(packet, arrived);
    if (taken) return true;
    if (taken.error().kind != Error::Kind::out_of_order) {
        refuse(taken.error().text);
        return false;
    }
    if (!ordered()) return true;
    // Cannot happen by accident.
    fail("on an ordered link, a " + taken.error().text);
    return false;
}

Result<Reception> HandSession::take(const proto::Envelope& packet, MonotonicTime arrived) {
    const Duration waited = now() - arrived;
    const auto age = [&](TimePoint time) -> std::optional<Duration> {
        if (!in_real_time()) return Duration::zero();
        if (!peer_clock_.known()) return std::nullopt;
        const Duration since_stamped = peer_clock_.age(time, arrived);
        const auto ours = client_.scene_time();
        return ours ? std::max(since_stamped, *ours - waited - time) : since_stamped;
    };
    const TimePoint latest =
        in_real_time() && peer_clock_.known()
            ? peer_clock_.time(arrived) + peer_clock_.uncertainty(arrived) + most_ahead + span_
            : TimePoint::max();
    Result<Reception> taken = intake_->receive(packet, age, latest);
    if (taken) {
        taken.value().waited = waited;
        client_.received(taken.value());
    }
    client_.packet(packet);
    if (intake_ && intake_->receiver().acknowledge(message_)) send(message_);
    return taken;
}

void HandSession::on_poll() {
    if (in_real_time() && state() == State::open && now() >= probe_at_) {
        probe();
        probe_at_ = now() + (peer_clock_.known() ? probe_period : first_probes);
    }
    receive_held();
}

void HandSession::probe() {
    proto::Probe& probe = *message_.mutable_probe();
    probe.Clear();
    probed_at_[++probes_ % probes_under_way] = now();
    probe.set_number(probes_);
    if (const auto ahead = this->ahead()) probe.set_ahead_ns(ahead->count());
    send(message_);
}

void HandSession::receive(const proto::Echo& echo) {
    if (!is_scene_time(echo.time_ns())) return refuse("echo: the time is out of range");
    if (echo.number() > probes_) return refuse("an echo of no probe");
    // Accepts one answer to each of our recent probes. One that comes later than that, from a peer that was
    // held up, tells nothing any more.
    if (probes_ - echo.number() >= probes_under_way) return;
    const auto sent = std::exchange(probed_at_[echo.number() % probes_under_way], std::nullopt);
    if (!sent) {
        if (ordered()) refuse("a second echo of one probe");
        return;
    }
    if (!peer_clock_.echoed(*sent, now(), scene_time(echo.time_ns()))) refuse("an echo from far off");
}

std::optional<Duration> HandSession::ahead() const {
    const auto ours = client_.scene_time();
    if (!ours || !peer_clock_.known()) return std::nullopt;
    return peer_clock_.time(now()) - *ours;
}

void HandSession::on_bye(const proto::Bye& theirs) {
    take_all_held();
    if (const auto gap = intake_->receiver().finish(scene_time(theirs.time_ns()), theirs.events()))
        client_.received({.gap = gap, .known = {gap->end, gap->end}, .events = {}, .more = false});
}

void HandSession::on_end(const SessionEnd& end) {
    take_all_held();
    client_.ended(end);
}

}  // namespace afferent
