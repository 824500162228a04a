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
    return Readouts(plan.readouts.parameters);
}

}  // namespace

class Controller::Packets {
  public:
    // Protobuf allocates for the first message, and again for a longer one. The longest possible message
    // makes it allocate here.
    explicit Packets(const PacketLayout& layout) : receiver(layout) {
        proto::Envelope longest;
        longest.set_position(1);
        longest.set_payload(std::string(PayloadCodec::most_bytes(layout), '\0'));
        FrameWriter writer;
        [[maybe_unused]] const Result<void> read = read_datagram(writer.datagram(longest), message, counts);
        counts = {};
    }

    PacketReceiver receiver;
    proto::Envelope message;
    FrameCounts counts;
};

Controller::Controller(const Plan& plan, std::optional<double> closing_rest_counts)
    : timing_(plan.timing),
      decoder_(plan.controller->decoder, plan.controller->afferents),
      parts_(part_decoders(*plan.controller)),
      part_forces_(plan.controller->parts.size()),
      readouts_(make_readouts(*plan.controller)),
      control_(plan.controller->control),
      closing_(at_rest(plan.controller->closing, closing_rest_counts), emg_period(*plan.controller)),
      opening_(plan.controller->opening, emg_period(*plan.controller)),
      packets_(plan.packets ? std::make_unique<Packets>(*plan.packets) : nullptr) {
    step_.parts = part_forces_;
}

Controller::~Controller() = default;
Controller::Controller(Controller&&) noexcept = default;
Controller& Controller::operator=(Controller&&) noexcept = default;

Result<void> Controller::receive(std::span<const std::byte> frame) {
    if (!packets_) return Error{Error::Kind::closed, "the scene's link carries no packets"};
    AFFERENT_TRY(read_datagram(frame, packets_->message, packets_->counts));
    AFFERENT_TRY(reception, packets_->receiver.receive(packets_->message));
    if (reception.gap) lose(reception.gap->begin, reception.gap->end);
    observe(reception.known.begin, reception.known.end, reception.events);
    return success();
}

const ControllerStep& Controller::step(TimePoint now, const Emg& emg) {
    const TimePoint silent_until = std::min(last_delivery(now), decoder_.heard_until() + timing_.heartbeat);
    decoder_.presume_silence(silent_until);
    if (parts_) parts_->presume_silence(silent_until);
    if (readouts_) readouts_->presume_silence(silent_until);
    follow(emg);
    step_.time = now;
    step_.estimate = decoder_.estimate(now);
    for (std::size_t i = 0; i < part_forces_.size(); ++i)
        part_forces_[i] = {parts_->estimate(i, now), std::nullopt};
    step_.parts = part_forces_;
    if (readouts_) {
        readouts_->step(now);
        step_.contacts = readouts_->contacts();
        step_.touches = readouts_->touches();
    }
    const GripCommand command = control_(step_.estimate, state_, step_.effort);
    step_.gain = command.gain;
    step_.command = command.command;
    return step_;
}

void Controller::follow(const Emg& emg) {
    // A reading that is not finite leaves the electrode at its last value.
    if (std::isfinite(emg.closing_counts)) {
        step_.closing_counts = emg.closing_counts;
        step_.effort.closing = closing_(emg.closing_counts);
    }
    if (std::isfinite(emg.opening_counts)) step_.effort.opening = opening_(emg.opening_counts);
}

// The deadline of the last packet that would have been delivered by now, had there been events for it.
TimePoint Controller::last_delivery(TimePoint now) const noexcept {
    const Duration since = now - timing_.delivery - scene_start;
    return scene_start + std::max(since, 0ns) / timing_.packet * timing_.packet;
}

void Controller::restart(TimePoint now) {
    decoder_.restart(now);
    if (parts_) parts_->restart(now);
    if (readouts_) readouts_->restart(now);
    state_ = GripState::operating;
}

std::size_t Controller::bytes() const {
    return sizeof *this - sizeof decoder_ + decoder_.bytes() + (parts_ ? parts_->bytes() : 0) +
           (readouts_ ? readouts_->bytes() - sizeof(Readouts) : 0) +
           part_forces_.capacity() * sizeof(PartForce);
}

Controller::Snapshot Controller::snapshot() const {
    ControllerStep step = step_;
    step.parts = {};
    step.contacts = {};
    step.touches = {};
    return {.decoder = decoder_.snapshot(),
            .parts = parts_ ? parts_->snapshot() : PartDecoders::Snapshot(),
            .part_forces = part_forces_,
            .readouts = readouts_ ? readouts_->snapshot() : Readouts::Snapshot(),
            .closing = closing_,
            .opening = opening_,
            .state = state_,
            .step = step,
            .position = packets_ ? packets_->receiver.position() : 0,
            .counted_events = packets_ ? packets_->receiver.counted_events() : 0};
}

void Controller::resume(const Snapshot& snapshot) {
    require(snapshot.parts.size() == part_forces_.size(), "snapshot.parts", "one for each part",
            static_cast<double>(snapshot.parts.size()));
    decoder_.resume(snapshot.decoder);
    if (parts_) parts_->resume(snapshot.parts);
    if (readouts_) readouts_->resume(snapshot.readouts);
    part_forces_ = snapshot.part_forces;
    closing_ = snapshot.closing;
    opening_ = snapshot.opening;
    state_ = snapshot.state;
    step_ = snapshot.step;
    step_.parts = part_forces_;
    if (packets_) packets_->receiver.resume(snapshot.position, snapshot.counted_events);
}

}  // namespace afferent
