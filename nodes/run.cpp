#include "afferent/nodes/run.hpp"

#include <algorithm>
#include <cassert>

#include "afferent/scene/scene_link.hpp"

namespace afferent {

Result<std::unique_ptr<Run>> Run::open(const Scene& scene, Output output, TableSource::Read standard_input) {
    std::unique_ptr<Run> run(new Run(scene, std::move(output)));
    auto coprocessor = CoprocessorSide::open(scene, std::move(standard_input));
    if (!coprocessor) return coprocessor.error();
    run->coprocessor_ = std::move(coprocessor.value());
    if (needs_decoder(scene) || hand_has_samples(scene)) {
        auto hand = HandSide::open(scene);
        if (!hand) return hand.error();
        run->hand_ = std::move(hand.value());
    }
    return run;
}

Run::Run(const Scene& scene, Output output) : scene_(scene), output_(std::move(output)) {
    coprocessor_output_.events = [this](std::span<const Event> events) { output_.events(events); };
    coprocessor_output_.scan = [this](const Scan& scan) { output_.scan(scan); };
    coprocessor_output_.packet = [this](const proto::Envelope& packet) { carry(packet); };
    coprocessor_output_.hand_over = [this](const Reception& reception) {
        if (hand_) hand_->receive(reception);
    };
    if (!in_process(scene)) {
        receiver_.emplace(packet_layout(scene));
        reader_ = std::make_unique<FrameReader>();
        const proto::Link& link = scene.description().link();
        if (link.has_channel()) {
            channel_.emplace(channel_parameters(link.channel(), scene.seed()));
            watchdog_.emplace(link_timing(link).freeze, link_timing(link).safe, MonotonicTime());
        }
        rehearse();
    }
}

// Protobuf takes memory with the first message that goes through it, and later for a longer one: a long
// packet that nobody receives does that now, and not while the run is under way.
void Run::rehearse() {
    proto::Envelope packet;
    packet.set_position(1);
    packet.set_spans(1);
    packet.set_count(1);
    packet.set_payload(std::string(std::max<std::size_t>(1024, 4 * scene_.addresses()), '\0'));
    write_and_read(packet);
}

std::size_t Run::write_and_read(const proto::Envelope& packet) {
    const auto bytes = writer_.stream_frame(packet);
    const auto space = reader_->space();
    assert(space.size() >= bytes.size());
    std::copy(bytes.begin(), bytes.end(), space.begin());
    reader_->filled(bytes.size());
    // What we have written ourselves is whole.
    [[maybe_unused]] const Result<bool> read = reader_->next(received_);
    assert(read && read.value());
    return bytes.size();
}

TimePoint Run::next() {
    if (const auto due = arrival()) return due->time;
    const TimePoint coprocessor = coprocessor_->next().time;
    return hand_ ? std::min(coprocessor, hand_->next().time) : coprocessor;
}

std::optional<Due> Run::arrival() {
    if (!channel_) return std::nullopt;
    Due other = coprocessor_->next();
    if (hand_) other = std::min(other, hand_->next());
    const auto time = channel_->next_arrival(other.time);
    if (!time) return std::nullopt;
    const Due due{*time, Kind::arrival, 0};
    return due < other ? std::optional(due) : std::nullopt;
}

void Run::arrive(TimePoint time) {
    if (read_datagram(channel_->arrive(), received_, arrived_)) receive(time);
}

void Run::receive(TimePoint arrived) {
    if (!hand_) {
        if (recording_) recording_->packet(received_);
        return;
    }
    const Result<Reception> reception = receiver_->receive(received_);
    const bool stale =
        reception && arrived - reception.value().known.end > link_timing(scene_.description().link()).stale;
    std::optional<std::uint64_t> late_at;
    if (stale) {
        if (hand_->receive(receiver_->discard(reception.value()), arrived)) late_at = hand_->next_step();
    } else if (reception) {
        if (watchdog_) watchdog_->heard(MonotonicTime(arrived - scene_start));
        if (hand_->receive(reception.value(), arrived)) {
            receiver_->count_late();
            late_at = hand_->next_step();
        }
    }
    if (recording_) recording_->packet(received_, late_at, stale);
}

void Run::record(HandRecording& recording) {
    recording_ = &recording;
    recording.begin(scene_start, true);
}

void Run::follow_grip_state() {
    if (!watchdog_ || !hand_) return;
    const GripState state = watchdog_->state(MonotonicTime(now_ - scene_start));
    if (recording_ && state != hand_->state())
        recording_->grip_state(state, watchdog_->reason(), hand_->next_step());
    hand_->set_state(state);
}

Result<void> Run::do_next() {
    if (const auto due = arrival()) {
        arrive(due->time);
        return success();
    }
    now_ = next();
    follow_grip_state();
    if (!hand_ || coprocessor_->next() < hand_->next()) return coprocessor_->do_next(coprocessor_output_);
    return hand_->do_next([this](const ControllerStep& done) { step(done); },
                          [this](const Scan& scan) { coprocessor_->push(scan, coprocessor_output_); });
}

void Run::finish(TimePoint end) {
    now_ = end;
    coprocessor_->finish(end, coprocessor_output_);
    if (channel_) {
        // What is still under way at the end is lost.
        while (const auto time = channel_->next_arrival(end)) arrive(*time);
        receiver_->finish(end, coprocessor_->packetizer()->events());
    }
    if (!recording_) return;
    proto::Bye bye;
    bye.set_reason(end < scene_start + scene_.duration() ? proto::INTERRUPTED : proto::END_OF_SCENE);
    bye.set_time_ns((end - scene_start).count());
    bye.set_packets(packets());
    bye.set_events(coprocessor_->packetizer()->events());
    recording_->bye(bye);
}

// Through the codec and back, as over a socket.
void Run::carry(const proto::Envelope& packet) {
    output_.packet(packet);
    if (channel_) {
        const auto bytes = writer_.datagram(packet);
        link_bytes_ += bytes.size();
        const std::uint64_t events = coprocessor_->packetizer()->events();
        channel_->send(now_, bytes, static_cast<std::uint32_t>(events - carried_events_));
        carried_events_ = events;
        return;
    }
    link_bytes_ += write_and_read(packet);
    receive(scene_start);
}

void Run::step(ControllerStep step) {
    if (!step.true_force_n) step.true_force_n = true_force_n(step.time);
    if (recording_) recording_->step(step, *hand_, receiver_ ? &*receiver_ : nullptr);
    output_.step(step);
}

std::optional<double> Run::true_force_n(TimePoint time) const {
    return coprocessor_->source() ? coprocessor_->source()->true_force_n(time) : std::nullopt;
}

std::uint64_t Run::packets() const noexcept {
    return coprocessor_->packetizer() ? coprocessor_->packetizer()->packets() : 0;
}

const SampleSource* Run::source() const noexcept {
    return coprocessor_->source() ? coprocessor_->source() : hand_ ? hand_->source() : nullptr;
}

}  // namespace afferent
