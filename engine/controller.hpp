// The controller of a hand: events in, estimate of the grip force, gain and command out. This is what a hand
// embeds.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "afferent/decoders/decoders.hpp"
#include "afferent/decoders/emg_control.hpp"
#include "afferent/decoders/readouts.hpp"
#include "afferent/hand/emg_envelope.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// The force on a patch or an element.
struct PartForce {
    Estimate estimate;
    std::optional<double> true_force_n;  // where it is known
};

// What the controller knew and did at one of its steps.
struct ControllerStep {
    TimePoint time;
    std::optional<double> true_force_n;  // where the hand is simulated
    Estimate estimate;
    // Where the scene asks for them, in the order of the plan's parts; valid until the next step.
    std::span<PartForce> parts;
    // The contacts that the step has estimated, and the touches that have been told since the last: where the
    // scene asks for them; valid until the next step.
    std::span<const PatchContact> contacts;
    std::span<const EdgeTouch> touches;
    double gain;
    double closing_counts;  // EMG, as sampled
    Effort effort;
    double command;  // to the motor, -1 (open) to 1 (close)
};

// Needs no file, no link, no clock and no thread. After construction it allocates nothing as long as packets
// and events stay below what the decoder states.
//
//     Controller controller(Scene::from_file("grasp.txtpb"));
//     controller.receive(frame);                                       // as the link has brought it
//     motor.drive(controller.step(now, {closing, opening}).command);   // 1000 times a second
//
// Packets, or the events of known spans, come in the order of time; what has come by the time of a step is in
// its estimate. Silence on the link is not the controller's business: who has a clock and a link sets the
// grip state.
class Controller {
  public:
    // Throws SceneError.
    explicit Controller(const Scene& scene) : Controller(make_plan(scene, Commands::wanted)) {}
    // The plan has a controller. Where a table of EMG does not state its counts at rest, they are given here.
    explicit Controller(const Plan& plan, std::optional<double> closing_rest_counts = {});
    ~Controller();
    Controller(Controller&&) noexcept;
    Controller& operator=(Controller&&) noexcept;

    // A packet as it came: one frame, without the length that streams put before it. `malformed` or
    // `out_of_order`: it was not used. A gap before it is known to the decoder as lost. `closed`: the scene's
    // link carries no packets.
    Result<void> receive(std::span<const std::byte> frame);

    // All events of [begin, end), sorted.
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
        decoder_.observe(begin, end, events);
        if (parts_) parts_->observe(begin, end, events);
        if (readouts_) readouts_->observe(begin, end, events);
    }
    // Nothing will be known of [begin, end).
    void lose(TimePoint begin, TimePoint end) {
        decoder_.lose(begin, end);
        if (parts_) parts_->lose(begin, end);
        if (readouts_) readouts_->lose(begin, end);
    }

    // Once for each period of the scene's EMG: what both electrodes read.
    const ControllerStep& step(TimePoint now, const Emg& emg);
    // Takes a sample without a step: the envelope follows it.
    void follow(const Emg& emg);

    // A new session: the decoder starts from nothing, and the grip is operating.
    void restart(TimePoint now);
    // Begins in the middle: nothing is known from before, but that the last span that was observed or lost
    // ended at heard_until.
    void resume_after(TimePoint now, TimePoint heard_until, const Estimate& last) {
        decoder_.resume_after(now, heard_until, last);
        if (parts_) parts_->resume_after(now, heard_until, last);
        if (readouts_) readouts_->resume_after(now, heard_until);
    }

    // The estimate that stands while nothing is known.
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
    // Whether the decoder ignores an afferent at present, because it contradicts the others.
    bool left_out(Address address) const { return decoder_.left_out(address); }
    const ControllerStep& last_step() const noexcept { return step_; }
    std::size_t bytes() const;
    // Null where the scene has none.
    const Readouts* readouts() const noexcept { return readouts_ ? &*readouts_ : nullptr; }

    // Everything that the next step depends on, as a value; packets continue where they were.
    struct Snapshot {
        GripDecoder::Snapshot decoder;
        PartDecoders::Snapshot parts;
        std::vector<PartForce> part_forces;
        Readouts::Snapshot readouts;
        EmgEnvelope closing;
        EmgEnvelope opening;
        GripState state;
        ControllerStep step;
        std::uint64_t position;  // of the packets received
        std::uint64_t counted_events;
    };
    Snapshot snapshot() const;
    // Continues from there, bit for bit. Throws ParameterError where the snapshot is of another scene.
    void resume(const Snapshot& snapshot);

  private:
    TimePoint last_delivery(TimePoint now) const noexcept;

    LinkTiming timing_;
    GripDecoder decoder_;
    std::optional<PartDecoders> parts_;
    std::vector<PartForce> part_forces_;
    std::optional<Readouts> readouts_;
    EmgControl control_;
    EmgEnvelope closing_;
    EmgEnvelope opening_;
    class Packets;
    std::unique_ptr<Packets> packets_;  // null where the link carries none
    GripState state_ = GripState::operating;
    ControllerStep step_{};
};

}  // namespace afferent
