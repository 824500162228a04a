#include "afferent/scene/run.hpp"

#include <algorithm>
#include <cassert>

#include "afferent/scene/scene_link.hpp"

namespace afferent {

bool needs_decoder(const Scene& scene) {
    return simulated_hand(scene) || scene.description().record().force() || scene.description().record().picture();
}

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
    coprocessor_output_.frame = [this](const Frame& frame) { output_.frame(frame); };
    coprocessor_output_.packet = [this](const proto::Envelope& packet) { carry(packet); };
    coprocessor_output_.hand_over = [this](const Reception& reception) {
        if (hand_) hand_->receive(reception);
    };
    if (!in_process(scene)) {
        receiver_.emplace(packet_layout(scene));
        reader_ = std::make_unique<FrameReader>();
        rehearse();
    }
}

// Protobuf takes memory with the first message that goes through it, and later for a longer one: a long packet that
// nobody receives does that now, and not while the run is under way.
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
    const TimePoint coprocessor = coprocessor_->next().time;
    return hand_ ? std::min(coprocessor, hand_->next().time) : coprocessor;
}

Result<void> Run::step() {
    if (!hand_ || coprocessor_->next() < hand_->next()) return coprocessor_->step(coprocessor_output_);
    return hand_->step([this](const Tick& t) { tick(t); }, [this](const Frame& frame) { coprocessor_->push(frame, coprocessor_output_); });
}

void Run::finish(TimePoint end) { coprocessor_->finish(end, coprocessor_output_); }

// Through the codec and back, as over a socket.
void Run::carry(const proto::Envelope& packet) {
    link_bytes_ += write_and_read(packet);
    if (!hand_) return;
    const Result<Reception> reception = receiver_->receive(received_);
    assert(reception);
    hand_->receive(reception.value());
}

void Run::tick(Tick tick) {
    if (!tick.true_force_n) tick.true_force_n = true_force_n(tick.time);
    output_.tick(tick);
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
