// The controller of a hand: events and EMG in; estimate of the grip force, gain and command out. To be
// included by programs that control a hand.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/engine/controller_step.hpp"
#include "afferent/hand/user.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/grip_state.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

struct Plan;
class Readouts;

// What the decoder of a scene is told of its afferents, for a decoder of one's own (decoder.hpp). Throws
// SceneError where the scene is wrong.
DecodedAfferents decoded_afferents(const Scene& scene);

// A step with as many parts as the plan's controller has and as many read-outs as it can tell at once, so
// that steps assigned to it allocate nothing. Empty where the plan has no controller.
ControllerStep step_with_room(const Plan& plan);

// Needs no file, no link, no clock and no thread. After construction it allocates nothing as long as packets
// and events stay below what the decoder states.
//
//     Controller controller(Scene::from_file("grasp.txtpb"));
//     controller.receive(frame);                                       // as the link has brought it
//     motor.drive(controller.step(now, {closing, opening}).command);   // 1000 times a second
//
// Packets, or the events of known spans, come in the order of time; what has come by the time of a step is in
// its estimate. The controller does not act on silence of the link: the program that has a clock and a link
// sets the grip state.
class Controller {
  public:
    // Throws SceneError where the scene is wrong.
    explicit Controller(const Scene& scene);
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
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    // Nothing will be known of [begin, end).
    void lose(TimePoint begin, TimePoint end);

    // Once for each period of the scene's EMG: what both electrodes read. Valid until the next step.
    const ControllerStep& step(TimePoint now, const Emg& emg);
    // Takes a sample without a step: the envelope follows it.
    void follow(const Emg& emg);

    // A new session: the decoder starts from nothing, and the grip is operating.
    void restart(TimePoint now);
    // Begins in the middle: nothing is known from before, but that the last span that was observed or lost
    // ended at heard_until.
    void resume_after(TimePoint now, TimePoint heard_until, const Estimate& last);
    // Replaces the estimate that stands while nothing is known.
    void correct(const Estimate& last);

    void set_state(GripState state) noexcept;
    GripState state() const noexcept;
    TimePoint heard_until() const noexcept;
    // How far back the events lie that an estimate can depend on.
    Duration history() const;
    // Whether the decoder ignores an afferent at present, because it contradicts the others.
    bool left_out(Address address) const;
    const ControllerStep& last_step() const noexcept;
    std::size_t bytes() const;
    // Null where the scene has none.
    const Readouts* readouts() const noexcept;

    // Everything that the next step depends on, as a value; packets continue where they were.
    struct Snapshot {
        struct State;
        std::shared_ptr<const State> state;
    };
    Snapshot snapshot() const;
    // Continues from there, bit for bit. Throws ParameterError where the snapshot is of another scene.
    void resume(const Snapshot& snapshot);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace afferent
