#include "afferent/nodes/run.hpp"

#include <algorithm>
#include <cassert>

#include "afferent/io/wire/payload.hpp"
#include "afferent/nodes/channel_parameters.hpp"

namespace afferent {
namespace {

// Records are written as soon as they are made.
constexpr std::size_t records_at_once = 16;

}  // namespace

Result<std::unique_ptr<Run>> Run::open(const Plan& plan, Observer observer, TableSource::Read standard_input,
                                       EventExchange* exchange, GivenTables given) {
    if (plan.scene.hand.ability_hand)
        return Error{Error::Kind::not_allowed,
                     plan.scene.file +
                         ": hand.ability_hand is on a line, in real time: `afferent hand` "
                         "drives it"};
    if (std::holds_alternative<scene::Chip>(plan.scene.source))
        return Error{
            Error::Kind::not_allowed,
            plan.scene.file + ": source.chip is on a line, in real time: `afferent coprocessor` reads it"};
    std::unique_ptr<Run> run(new Run(plan, std::move(observer)));
    AFFERENT_TRY(coprocessor,
                 CoprocessorEnd::open(plan, std::move(standard_input), exchange, std::move(given.forces)));
    run->coprocessor_ = std::move(coprocessor);
    AFFERENT_TRY(live, Outputs::open(plan.scene, OutputThread::link));
    run->live_ = std::move(live);
    if (plan.controller || plan.samples_from == SamplesFrom::hand) {
        AFFERENT_TRY(hand, HandEnd::open(plan, std::move(given.emg)));
        AFFERENT_TRY(recording, Outputs::open(plan.scene, OutputThread::writer));
        run->writer_ = HandWriter(std::move(recording));
        run->hand_.emplace(std::move(hand), run->records_);
    }
    return run;
}

Run::Run(const Plan& plan, Observer observer)
    : plan_(plan),
      observer_(std::move(observer)),
      step_(step_with_room(plan)),
      records_(records_at_once, step_) {
    coprocessor_observer_.events = [this](std::span<const Event> events) { observer_.events(events); };
    coprocessor_observer_.scan = [this](const Scan& scan) { observer_.scan(scan); };
    coprocessor_observer_.packet = [this](const proto::Envelope& packet) { carry(packet); };
    coprocessor_observer_.span = [this](const Reception& reception) {
        live_.observe(reception.known, reception.events);
        if (hand_) hand_->link_end().receive(reception);
    };
    if (plan.packets) {
        intake_.emplace(*plan.packets, plan.timing.stale);
        reader_ = std::make_unique<FrameReader>();
        if (plan.scene.link.channel) {
            channel_.emplace(channel_parameters(plan.scene));
            if (plan.packets->acknowledged) way_back_.emplace(way_back_parameters(plan.scene));
            order_ = PacketOrder(plan.timing.overtaking);
            guard_ = GripGuard::within_session({.freeze = plan.timing.freeze, .safe = plan.timing.safe},
                                               MonotonicTime());
        }
        preallocate();
    }
}

// Protobuf allocates memory for the first message, and again for a longer one. A long packet that nobody
// receives makes it allocate now and not during the run.
void Run::preallocate() {
    proto::Envelope packet;
    packet.set_position(1);
    const std::size_t usual = std::max<std::size_t>(1024, 4 * std::size_t{plan_.addresses});
    packet.set_payload(std::string(std::min(usual, PayloadCodec::most_bytes(*plan_.packets)), '\0'));
    write_and_read(packet);
}

std::size_t Run::write_and_read(const proto::Envelope& packet) {
    const auto bytes = frames_.stream_frame(packet);
    // The reader allocates once for every frame that is longer than those before.
    for (auto left = bytes; !left.empty();) {
        const auto space = reader_->space();
        const auto piece = left.first(std::min(left.size(), space.size()));
        std::copy(piece.begin(), piece.end(), space.begin());
        reader_->filled(piece.size());
        left = left.subspan(piece.size());
    }
    // A frame that did not leave the process cannot be damaged.
    [[maybe_unused]] const Result<bool> read = reader_->next(received_);
    assert(read && read.value());
    return bytes.size();
}

TimePoint Run::next() {
    if (const auto due = arrival()) return due->time;
    const TimePoint coprocessor = coprocessor_->next().time;
    return hand_ ? std::min(coprocessor, hand_->link_end().next().time) : coprocessor;
}

std::optional<Due> Run::arrival() {
    if (!channel_) return std::nullopt;
    Due other = coprocessor_->next();
    if (hand_) other = std::min(other, hand_->link_end().next());
    const TimePoint time =
        std::min(channel_->next_arrival(other.time).value_or(TimePoint::max()), wait_ends());
    const Due due{time, Kind::arrival, 0};
    return due < other ? std::optional(due) : std::nullopt;
}

TimePoint Run::wait_ends() const {
    const auto due = order_.due();
    return due ? virtual_time(*due) : TimePoint::max();
}

void Run::arrive(TimePoint time) {
    if (channel_->next_arrival(time) && read_datagram(channel_->arrive(), received_, arrived_)) {
        const bool waits = receives() && order_.hold(received_, intake_->receiver(), wall_time(time));
        if (!waits) receive(received_, time, time);
    }
    receive_held(time, wall_time(time));
}

void Run::receive_held(TimePoint now, MonotonicTime waited_until) {
    while (PacketOrder::Held* next = order_.next(intake_->receiver(), waited_until))
        receive(next->packet, virtual_time(next->arrived), now);
}

void Run::receive(proto::Envelope& packet, TimePoint arrived, TimePoint now) {
    if (!hand_ && recording_) recording_->packet(packet);
    if (!receives() && !plan_.packets->acknowledged) return;
    const auto age = [arrived](TimePoint time) { return arrived - time; };
    if (const Result<Reception> reception = intake_->receive(packet, age)) {
        live_.observe(reception.value().known, reception.value().events);
        send_acknowledgement(now);
        if (!hand_) return;
        if (guard_ && reception.value().measured()) guard_->heard(wall_time(arrived));
        const PacketReceiver& receiver = intake_->receiver();
        hand_->receive(reception.value(), {receiver.position(), receiver.counted_events()}, now);
    } else {
        send_acknowledgement(now);
    }
    if (!hand_) return;
    if (writer_.records()) hand_->packet(packet);
    writer_.write(records_);
}

void Run::send_acknowledgement(TimePoint now) {
    if (!intake_->receiver().acknowledge(answer_)) return;
    const auto bytes = frames_.datagram(answer_);
    acknowledgement_bytes_ += bytes.size();
    if (way_back_)
        way_back_->send(now, bytes, 0);
    else
        answers_ = true;
}

void Run::take_acknowledgements(TimePoint until) {
    Packetizer* const packetizer = coprocessor_->packetizer();
    if (answers_) packetizer->acknowledge(answer_.acknowledgement());
    answers_ = false;
    while (way_back_ && way_back_->next_arrival(until))
        if (read_datagram(way_back_->arrive(), answer_, arrived_back_) && answer_.has_acknowledgement())
            packetizer->acknowledge(answer_.acknowledgement());
}

Result<void> Run::record(const std::filesystem::path& file, const proto::Hello& hello) {
    auto recording = HandRecording::create(file, plan_, proto::RUN, this->hand());
    if (!recording) return recording.error();
    recording.value().hello(hello);
    recording.value().begin(scene_start, true);
    if (hand_)
        writer_.record(std::move(recording.value()));
    else
        recording_ = std::move(recording.value());
    return success();
}

Result<void> Run::close() {
    AFFERENT_TRY(live_.close());
    if (hand_) return writer_.close(records_, now_);
    return recording_ ? recording_->close(now_) : Result<void>(success());
}

// A perfect channel is never silent, so the hand needs no guard.
void Run::follow_grip_state() {
    if (!guard_ || !hand_) return;
    hand_->follow(guard_->state(wall_time(now_)), guard_->cause());
    writer_.write(records_);
}

Result<void> Run::do_next(Duration behind) {
    if (const auto due = arrival()) {
        arrive(due->time);
        return success();
    }
    now_ = next();
    follow_grip_state();
    take_acknowledgements(now_);
    if (!hand_ || coprocessor_->next() < hand_->link_end().next())
        return coprocessor_->do_next(coprocessor_observer_, behind);
    HandEnd& link_end = hand_->link_end();
    const bool done =
        link_end.do_next([this](const ControllerStep& step) { this->step(step); },
                         [&](const Scan& scan) { coprocessor_->push(scan, coprocessor_observer_, behind); });
    return done ? Result<void>(success()) : link_end.source()->refusal();
}

void Run::finish(TimePoint end) {
    now_ = end;
    coprocessor_->finish(end, coprocessor_observer_);
    if (channel_) {
        // What has not arrived by the end is lost.
        while (const auto time = channel_->next_arrival(end)) arrive(*time);
        receive_held(end, MonotonicTime::max());
        intake_->receiver().finish(end, coprocessor_->packetizer()->events());
    }
    if (!coprocessor_->packetizer()) return;
    proto::Envelope last;
    proto::Bye& bye = *last.mutable_bye();
    bye.set_reason(end < plan_.end() ? proto::INTERRUPTED : proto::END_OF_SCENE);
    bye.set_time_ns((end - scene_start).count());
    bye.set_packets(packets());
    bye.set_events(coprocessor_->packetizer()->events());
    if (recording_) recording_->bye(bye);
    if (hand_) hand_->bye(last);
    writer_.write(records_);
}

// Sends the packet through the codec and back, as a socket would.
void Run::carry(const proto::Envelope& packet) {
    observer_.packet(packet);
    if (channel_) {
        const auto bytes = frames_.datagram(packet);
        link_bytes_ += bytes.size();
        const std::uint64_t events = coprocessor_->packetizer()->events();
        channel_->send(now_, bytes, static_cast<std::uint32_t>(events - carried_events_));
        carried_events_ = events;
        return;
    }
    link_bytes_ += write_and_read(packet);
    receive(received_, scene_start, scene_start);
}

void Run::step(const ControllerStep& step) {
    step_ = step;
    if (const SampleSource* source = coprocessor_->source(); source && !step_.true_force_n) {
        step_.true_force_n = source->true_force_n(step.time);
        source->tell_true_forces(step_);
    }
    hand_->did(step_);
    writer_.write(records_);
    observer_.step(step_);
}

std::optional<double> Run::true_force_n(TimePoint time) const {
    return coprocessor_->source() ? coprocessor_->source()->true_force_n(time) : std::nullopt;
}

PacketCounts Run::received() const noexcept {
    if (!intake_) return {};
    PacketCounts counts = intake_->receiver().counts();
    if (hand_) counts.late = hand_->late_packets();
    return counts;
}

std::string Run::safe_reason() const {
    return hand_ && hand_->state() == GripState::safe ? text(guard_->cause()) : "";
}

std::uint64_t Run::packets() const noexcept {
    return coprocessor_->packetizer() ? coprocessor_->packetizer()->packets() : 0;
}

const SampleSource* Run::source() const noexcept {
    if (coprocessor_->source()) return coprocessor_->source();
    return hand_ ? hand_->link_end().source() : nullptr;
}

}  // namespace afferent
