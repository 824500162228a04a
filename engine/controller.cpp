#include "afferent/engine/controller.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "afferent/engine/force_decoders.hpp"
#include "afferent/engine/presumed_spans.hpp"
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
    step.readouts.resize(Readouts::most_told * plan.controller->readouts.parameters.size());
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
    TimePoint presumed_until;
    std::vector<Event> presumed;
    TimePoint due_until;
    TimePoint presumes_from;
    std::uint64_t position;  // of the packets received
    std::uint64_t counted_events;
};

class Controller::Impl {
  public:
    Impl(const Plan& plan, std::optional<double> closing_rest_counts);

    Result<void> receive(std::span<const std::byte> frame);
    void receive(const Reception& reception);
    std::span<const std::byte> acknowledgement();
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        if (end <= due_until_) distrust_link();
        if (presumed_) presumed_->forget();
        told_.observe(begin, end, events);
        if (readouts_) readouts_->observe(begin, end, events);
    }
    void lose(TimePoint begin, TimePoint end) {
        if (begin < due_until_) distrust_link();
        if (presumed_) presumed_->forget();
        lost_until_ = end;
        told_.lose(begin, end);
        if (readouts_) readouts_->lose(begin, end);
    }
    const ControllerStep& step(TimePoint now, const Emg& emg);
    void follow(const Emg& emg);
    void restart(TimePoint now);
    void resume_after(TimePoint now, TimePoint heard_until, const Estimate& last, TimePoint presumes_from) {
        presume_anew();
        step_.time = now;
        due_until_ = last_delivery(now);
        presumes_from_ = presumes_from;
        told_.resume_after(now, heard_until, last);
        if (readouts_) readouts_->resume_after(now, heard_until);
    }
    void correct(const Estimate& last) { told_.correct(last); }

    void set_state(GripState state) noexcept { state_ = state; }
    GripState state() const noexcept { return state_; }
    TimePoint heard_until() const noexcept { return told_.heard_until(); }
    TimePoint presumes_from() const noexcept { return presumes_from_; }
    Duration history() const {
        return readouts_ ? std::max(told_.grip.history(), readouts_->history()) : told_.grip.history();
    }
    bool left_out(Address address) const { return told_.grip.left_out(address); }
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
    ForceDecoders& presume(TimePoint delivered);
    // A packet has come late or not at all, so that what was presumed may be wrong.
    void distrust_link() noexcept { presumes_from_ = step_.time + timing_.distrust; }
    void presume_anew() noexcept {
        if (presumed_) presumed_->forget();
        due_until_ = presumes_from_ = scene_start;
    }

    LinkTiming timing_;
    bool presumes_;
    TimePoint due_until_ = scene_start;      // all before would have come by the last step
    TimePoint presumes_from_ = scene_start;  // until then nothing is presumed
    ForceDecoders told_;
    std::optional<PresumedSpans> presumed_;  // where what is presumed may have spikes
    std::optional<Readouts> readouts_;       // of what was told
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
      presumes_(plan.controller->presumes),
      told_{{plan.controller->decoder, plan.controller->afferents}, part_decoders(*plan.controller)},
      readouts_(make_readouts(*plan.controller)),
      control_(plan.controller->control),
      reflexes_(plan.controller->reflexes),
      closing_(at_rest(plan.controller->closing, closing_rest_counts), emg_period(*plan.controller)),
      opening_(plan.controller->opening, emg_period(*plan.controller)),
      packets_(plan.packets ? std::make_unique<ReceivedPackets>(*plan.packets) : nullptr),
      step_(step_with_room(plan)) {
    step_.readouts.clear();
    if (presumes_ && plan.packets->tolerance > 0ns)
        presumed_.emplace(told_, std::max<std::size_t>(256, plan.addresses));
}

Result<void> Controller::Impl::receive(std::span<const std::byte> frame) {
    if (!packets_) return Error{Error::Kind::closed, "the scene's link carries no packets"};
    if (Result<void> read = read_datagram(frame, packets_->message, packets_->counts); !read) {
        packets_->receiver.lose_frame();
        return read;
    }
    AFFERENT_TRY(reception, packets_->receiver.receive(packets_->message));
    receive(reception);
    return success();
}

void Controller::Impl::receive(const Reception& reception) {
    if (reception.gap) lose(reception.gap->begin, reception.gap->end);
    observe(reception.known.begin, reception.known.end, reception.events);
    if (presumed_ && reception.presumed_until > reception.known.end)
        presumed_->presume(reception.presumed_until, reception.presumed);
}

std::span<const std::byte> Controller::Impl::acknowledgement() {
    if (!packets_ || !packets_->receiver.acknowledge(packets_->answer)) return {};
    return packets_->frames.datagram(packets_->answer);
}

const ControllerStep& Controller::Impl::step(TimePoint now, const Emg& emg) {
    const TimePoint delivered = last_delivery(now);
    const bool heard = told_.heard_until() >= delivered && lost_until_ + timing_.heartbeat <= delivered;
    follow(emg);
    step_.time = now;
    ForceDecoders& decoders = presume(delivered);
    decoders.estimate(now, step_);
    if (&decoders != &told_) told_.correct(step_);
    if (readouts_) readouts_->step(now, step_.readouts);
    const GripCommand command = control_(step_.estimate, state_, step_.effort);
    step_.gain = command.gain;
    step_.command = reflexes_(now, step_.estimate, heard, state_, command);
    return step_;
}

// The decoders that know, or presume, what was before `delivered`. They presume at most one heartbeat after
// the last packet.
ForceDecoders& Controller::Impl::presume(TimePoint delivered) {
    step_.known_until = told_.heard_until();
    due_until_ = delivered;
    if (!presumes_ || step_.time < presumes_from_) return told_;
    const TimePoint until =
        std::min(delivered, presumed_ ? presumed_->until() : told_.heard_until() + timing_.heartbeat);
    if (until <= told_.heard_until()) return told_;
    step_.known_until = until;
    if (presumed_) return presumed_->decoded(told_, until, timing_.packet);
    told_.presume_silence(until);
    if (readouts_) readouts_->presume_silence(until);
    return told_;
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
    presume_anew();
    told_.restart(now);
    if (readouts_) readouts_->restart(now);
    reflexes_.restart();
    lost_until_ = TimePoint::min();
    state_ = GripState::operating;
}

std::size_t Controller::Impl::bytes() const {
    return sizeof *this + told_.heap_bytes() + (presumed_ ? presumed_->bytes() - sizeof *presumed_ : 0) +
           (readouts_ ? readouts_->bytes() - sizeof(Readouts) : 0) +
           step_.parts.capacity() * sizeof(PartForce) + step_.readouts.capacity() * sizeof(PatchReadout);
}

Controller::Snapshot::State Controller::Impl::snapshot() const {
    std::vector<Event> presumed;
    if (presumed_) presumed.assign(presumed_->events().begin(), presumed_->events().end());
    return {.decoder = told_.grip.snapshot(),
            .parts = told_.parts ? told_.parts->snapshot() : PartDecoders::Snapshot(),
            .readouts = readouts_ ? readouts_->snapshot() : Readouts::Snapshot(),
            .reflexes = reflexes_,
            .lost_until = lost_until_,
            .closing = closing_,
            .opening = opening_,
            .state = state_,
            .step = step_,
            .presumed_until = presumed_ ? presumed_->until() : scene_start,
            .presumed = std::move(presumed),
            .due_until = due_until_,
            .presumes_from = presumes_from_,
            .position = packets_ ? packets_->receiver.position() : 0,
            .counted_events = packets_ ? packets_->receiver.counted_events() : 0};
}

void Controller::Impl::resume(const Snapshot::State& snapshot) {
    require(snapshot.parts.size() == step_.parts.size(), "snapshot.parts", "one for each part",
            static_cast<double>(snapshot.parts.size()));
    told_.grip.resume(snapshot.decoder);
    if (told_.parts) told_.parts->resume(snapshot.parts);
    if (presumed_) presumed_->presume(snapshot.presumed_until, snapshot.presumed);
    due_until_ = snapshot.due_until;
    presumes_from_ = snapshot.presumes_from;
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
void Controller::receive(const Reception& reception) { impl_->receive(reception); }
std::span<const std::byte> Controller::acknowledgement() { return impl_->acknowledgement(); }
void Controller::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    impl_->observe(begin, end, events);
}
void Controller::lose(TimePoint begin, TimePoint end) { impl_->lose(begin, end); }
const ControllerStep& Controller::step(TimePoint now, const Emg& emg) { return impl_->step(now, emg); }
void Controller::follow(const Emg& emg) { impl_->follow(emg); }
void Controller::restart(TimePoint now) { impl_->restart(now); }
void Controller::resume_after(TimePoint now, TimePoint heard_until, const Estimate& last,
                              TimePoint presumes_from) {
    impl_->resume_after(now, heard_until, last, presumes_from);
}
void Controller::correct(const Estimate& last) { impl_->correct(last); }
void Controller::set_state(GripState state) noexcept { impl_->set_state(state); }
GripState Controller::state() const noexcept { return impl_->state(); }
TimePoint Controller::heard_until() const noexcept { return impl_->heard_until(); }
TimePoint Controller::presumes_from() const noexcept { return impl_->presumes_from(); }
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
