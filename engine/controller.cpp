#include "afferent/engine/controller.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/runtime/parameter_error.hpp"
#include "afferent/scene/part_plans.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {
namespace {

Duration emg_period(const ControllerPlan& plan) { return from_seconds(1 / plan.emg_rate_hz); }

EmgEnvelope::Parameters at_rest(EmgEnvelope::Parameters electrode, std::optional<double> rest_counts) {
    electrode.rest_counts = rest_counts.value_or(electrode.rest_counts);
    return electrode;
}

std::optional<PartDecoders> part_decoders(const ControllerPlan& plan) {
    if (plan.parts.empty()) return std::nullopt;
    return make_part_decoders(plan);
}

std::optional<Readouts> make_readouts(const ControllerPlan& plan) {
    if (plan.readouts.parameters.empty()) return std::nullopt;
    return std::optional<Readouts>(plan.readouts.parameters);
}

}  // namespace

DecodedAfferents decoded_afferents(const Scene& scene) {
    return make_plan(scene, Commands::wanted).controller->afferents;
}

ControllerStep step_with_room(const Plan& plan) {
    ControllerStep step{};
    if (!plan.controller) return step;
    step.parts.resize(plan.controller->parts.size());
    step.readouts.resize(plan.controller->readouts.parameters.size());
    return step;
}

struct Controller::Snapshot::State {
    GripDecoder::Snapshot decoder;
    PartDecoders::Snapshot parts;
    Readouts::Snapshot readouts;
    Reflexes reflexes;
    TimePoint lost_until;
    EmgEnvelope closing;
    EmgEnvelope opening;
    GripState state;
    ControllerStep step;
    std::uint64_t position;  // of the packets received
    std::uint64_t counted_events;
};

class Controller::Impl {
  public:
    Impl(const Plan& plan, std::optional<double> closing_rest_counts);

    Result<void> receive(std::span<const std::byte> frame);
    std::span<const std::byte> acknowledgement();
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        decoder_.observe(begin, end, events);
        if (parts_) parts_->observe(begin, end, events);
        if (readouts_) readouts_->observe(begin, end, events);
    }
    void lose(TimePoint begin, TimePoint end) {
        lost_until_ = end;
        decoder_.lose(begin, end);
        if (parts_) parts_->lose(begin, end);
        if (readouts_) readouts_->lose(begin, end);
    }
    const ControllerStep& step(TimePoint now, const Emg& emg);
    void follow(const Emg& emg);
    void restart(TimePoint now);
    void resume_after(TimePoint now, TimePoint heard_until, const Estimate& last) {
        decoder_.resume_after(now, heard_until, last);
        if (parts_) parts_->resume_after(now, heard_until, last);
        if (readouts_) readouts_->resume_after(now, heard_until);
    }
    void correct(const Estimate& last) {
        decoder_.correct(last);
        if (parts_) parts_->correct(last);
    }

    void set_state(GripState state) noexcept { state_ = state; }
    GripState state() const noexcept { return state_; }
    TimePoint heard_until() const noexcept { return decoder_.heard_until(); }
    Duration history() const {
        return readouts_ ? std::max(decoder_.history(), readouts_->history()) : decoder_.history();
    }
    bool left_out(Address address) const { return decoder_.left_out(address); }
    const ControllerStep& last_step() const noexcept { return step_; }
    std::size_t bytes() const;
    const Readouts* readouts() const noexcept { return readouts_ ? &*readouts_ : nullptr; }

    Snapshot::State snapshot() const;
    void resume(const Snapshot::State& snapshot);

  private:
    class ReceivedPackets {
      public:
        // Protobuf allocates for the first message, and again for a longer one. The longest possible message
        // makes it allocate here.
        explicit ReceivedPackets(const PacketLayout& layout) : receiver(layout) {
            proto::Envelope longest;
            longest.set_position(1);
            longest.set_payload(std::string(PayloadCodec::most_bytes(layout), '\0'));
            FrameWriter writer;
            [[maybe_unused]] const Result<void> read =
                read_datagram(writer.datagram(longest), message, counts);
            counts = {};
        }

        PacketReceiver receiver;
        proto::Envelope message;
        FrameCounts counts;
        proto::Envelope answer;
        FrameWriter frames;
    };

    TimePoint last_delivery(TimePoint now) const noexcept;

    LinkTiming timing_;
    // Where spikes are presumed, a span without a packet may have some: they come with the next.
    bool presumes_silence_;
    GripDecoder decoder_;
    std::optional<PartDecoders> parts_;
    std::optional<Readouts> readouts_;
    EmgControl control_;
    Reflexes reflexes_;
    TimePoint lost_until_ = TimePoint::min();  // the end of the last span that was lost
    EmgEnvelope closing_;
    EmgEnvelope opening_;
    std::unique_ptr<ReceivedPackets> packets_;  // null where the link carries none
    GripState state_ = GripState::operating;
    ControllerStep step_;
};

Controller::Impl::Impl(const Plan& plan, std::optional<double> closing_rest_counts)
    : timing_(plan.timing),
      presumes_silence_(!plan.packets || plan.packets->tolerance == 0ns),
      decoder_(plan.controller->decoder, plan.controller->afferents),
      parts_(part_decoders(*plan.controller)),
      readouts_(make_readouts(*plan.controller)),
      control_(plan.controller->control),
      reflexes_(plan.controller->reflexes),
      closing_(at_rest(plan.controller->closing, closing_rest_counts), emg_period(*plan.controller)),
      opening_(plan.controller->opening, emg_period(*plan.controller)),
      packets_(plan.packets ? std::make_unique<ReceivedPackets>(*plan.packets) : nullptr),
      step_(step_with_room(plan)) {
    step_.readouts.clear();
}

Result<void> Controller::Impl::receive(std::span<const std::byte> frame) {
    if (!packets_) return Error{Error::Kind::closed, "the scene's link carries no packets"};
    if (Result<void> read = read_datagram(frame, packets_->message, packets_->counts); !read) {
        packets_->receiver.lose_frame();
        return read;
    }
    AFFERENT_TRY(reception, packets_->receiver.receive(packets_->message));
    if (reception.gap) lose(reception.gap->begin, reception.gap->end);
    observe(reception.known.begin, reception.known.end, reception.events);
    return success();
}

std::span<const std::byte> Controller::Impl::acknowledgement() {
    if (!packets_ || !packets_->receiver.acknowledge(packets_->answer)) return {};
    return packets_->frames.datagram(packets_->answer);
}

const ControllerStep& Controller::Impl::step(TimePoint now, const Emg& emg) {
    const TimePoint delivered = last_delivery(now);
    const bool heard = decoder_.heard_until() >= delivered && lost_until_ + timing_.heartbeat <= delivered;
    const TimePoint silent_until = presumes_silence_
                                       ? std::min(delivered, decoder_.heard_until() + timing_.heartbeat)
                                       : TimePoint::min();
    step_.known_until = std::max(decoder_.heard_until(), silent_until);
    decoder_.presume_silence(silent_until);
    if (parts_) parts_->presume_silence(silent_until);
    if (readouts_) readouts_->presume_silence(silent_until);
    follow(emg);
    step_.time = now;
    step_.estimate = decoder_.estimate(now);
    for (std::size_t i = 0; i < step_.parts.size(); ++i)
        step_.parts[i] = {parts_->estimate(i, now), std::nullopt};
    if (readouts_) readouts_->step(now, step_.readouts);
    const GripCommand command = control_(step_.estimate, state_, step_.effort);
    step_.gain = command.gain;
    step_.command = reflexes_(now, step_.estimate, heard, state_, command);
    return step_;
}

void Controller::Impl::follow(const Emg& emg) {
    // A reading that is not finite leaves the electrode at its last value.
    if (std::isfinite(emg.closing_counts)) {
        step_.closing_counts = emg.closing_counts;
        step_.effort.closing = closing_(emg.closing_counts);
    }
    if (std::isfinite(emg.opening_counts)) step_.effort.opening = opening_(emg.opening_counts);
}

// The deadline of the last packet that would have been delivered by now, had there been events for it.
TimePoint Controller::Impl::last_delivery(TimePoint now) const noexcept {
    const Duration since = now - timing_.delivery - scene_start;
    return scene_start + std::max(since, 0ns) / timing_.packet * timing_.packet;
}

void Controller::Impl::restart(TimePoint now) {
    decoder_.restart(now);
    if (parts_) parts_->restart(now);
    if (readouts_) readouts_->restart(now);
    reflexes_.restart();
    lost_until_ = TimePoint::min();
    state_ = GripState::operating;
}

std::size_t Controller::Impl::bytes() const {
    return sizeof *this - sizeof decoder_ + decoder_.bytes() + (parts_ ? parts_->bytes() : 0) +
           (readouts_ ? readouts_->bytes() - sizeof(Readouts) : 0) +
           step_.parts.capacity() * sizeof(PartForce) + step_.readouts.capacity() * sizeof(PatchReadout);
}

Controller::Snapshot::State Controller::Impl::snapshot() const {
    return {.decoder = decoder_.snapshot(),
            .parts = parts_ ? parts_->snapshot() : PartDecoders::Snapshot(),
            .readouts = readouts_ ? readouts_->snapshot() : Readouts::Snapshot(),
            .reflexes = reflexes_,
            .lost_until = lost_until_,
            .closing = closing_,
            .opening = opening_,
            .state = state_,
            .step = step_,
            .position = packets_ ? packets_->receiver.position() : 0,
            .counted_events = packets_ ? packets_->receiver.counted_events() : 0};
}

void Controller::Impl::resume(const Snapshot::State& snapshot) {
    require(snapshot.parts.size() == step_.parts.size(), "snapshot.parts", "one for each part",
            static_cast<double>(snapshot.parts.size()));
    decoder_.resume(snapshot.decoder);
    if (parts_) parts_->resume(snapshot.parts);
    if (readouts_) readouts_->resume(snapshot.readouts);
    reflexes_ = snapshot.reflexes;
    lost_until_ = snapshot.lost_until;
    closing_ = snapshot.closing;
    opening_ = snapshot.opening;
    state_ = snapshot.state;
    step_ = snapshot.step;
    if (packets_) packets_->receiver.resume(snapshot.position, snapshot.counted_events);
}

Controller::Controller(const Scene& scene) : Controller(make_plan(scene, Commands::wanted)) {}
Controller::Controller(const Plan& plan, std::optional<double> closing_rest_counts)
    : impl_(std::make_unique<Impl>(plan, closing_rest_counts)) {}
Controller::~Controller() = default;
Controller::Controller(Controller&&) noexcept = default;
Controller& Controller::operator=(Controller&&) noexcept = default;

Result<void> Controller::receive(std::span<const std::byte> frame) { return impl_->receive(frame); }
std::span<const std::byte> Controller::acknowledgement() { return impl_->acknowledgement(); }
void Controller::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    impl_->observe(begin, end, events);
}
void Controller::lose(TimePoint begin, TimePoint end) { impl_->lose(begin, end); }
const ControllerStep& Controller::step(TimePoint now, const Emg& emg) { return impl_->step(now, emg); }
void Controller::follow(const Emg& emg) { impl_->follow(emg); }
void Controller::restart(TimePoint now) { impl_->restart(now); }
void Controller::resume_after(TimePoint now, TimePoint heard_until, const Estimate& last) {
    impl_->resume_after(now, heard_until, last);
}
void Controller::correct(const Estimate& last) { impl_->correct(last); }
void Controller::set_state(GripState state) noexcept { impl_->set_state(state); }
GripState Controller::state() const noexcept { return impl_->state(); }
TimePoint Controller::heard_until() const noexcept { return impl_->heard_until(); }
Duration Controller::history() const { return impl_->history(); }
bool Controller::left_out(Address address) const { return impl_->left_out(address); }
const ControllerStep& Controller::last_step() const noexcept { return impl_->last_step(); }
std::size_t Controller::bytes() const { return sizeof *this + impl_->bytes(); }
const Readouts* Controller::readouts() const noexcept { return impl_->readouts(); }

Controller::Snapshot Controller::snapshot() const {
    return {std::make_shared<const Snapshot::State>(impl_->snapshot())};
}

void Controller::resume(const Snapshot& snapshot) { impl_->resume(*snapshot.state); }

}  // namespace afferent
