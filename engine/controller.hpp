// The controller of a hand: events and EMG in; estimate of the grip force, gain and command out. Included by
// programs that control a hand.
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
struct Reception;
class Readouts;

// The description of a scene's afferents, for a decoder of your own (decoder.hpp). Throws SceneError if the
// scene is invalid.
DecodedAfferents decoded_afferents(const Scene& scene);

// A step with capacity for all parts and read-outs of the plan's controller: assigning its steps to this one
// allocates nothing. Empty if the plan has no controller.
ControllerStep step_with_room(const Plan& plan);

// Needs no file, link, clock or thread. After construction it allocates nothing, up to the rate of events
// that its decoder states.
//
//     Controller controller(Scene::from_file("grasp.txtpb"));
//     controller.receive(frame);                                       // as the link has brought it
//     motor.drive(controller.step(now, {closing, opening}).command);   // 1000 times a second
//
// Packets, or the events of known spans, arrive in order of time; a step's estimate contains all that arrived
// before it. The controller does not watch the link for silence: the program that has the link and a clock
// does, and sets the grip state.
class Controller {
  public:
    // Throws SceneError if the scene is invalid.
    explicit Controller(const Scene& scene);
    // The plan has a controller. `closing_rest_counts`: the EMG counts at rest, if the scene's table of EMG
    // does not state them.
    explicit Controller(const Plan& plan, std::optional<double> closing_rest_counts = {});
    ~Controller();
    Controller(Controller&&) noexcept;
    Controller& operator=(Controller&&) noexcept;

    // Takes one packet: a frame without the length prefix of streams. A gap before it is passed to the
    // decoder as lost. Where link.encoding is PREDICTED on a stream, every packet is needed: one that is left
    // out is noticed only within sixteen. Fails with `malformed` or `out_of_order` if the packet was not
    // used, and with `closed` if the scene's link carries no packets.
    Result<void> receive(std::span<const std::byte> frame);
    // Takes what a packet told, where somebody else has read it.
    void receive(const Reception& reception);
    // What is to be sent to the coprocessor now, where packets may be lost and link.encoding is PREDICTED: a
    // frame that acknowledges what has been received. To be asked after each receive(); empty: nothing. Valid
    // until the next call.
    std::span<const std::byte> acknowledgement();

    // Takes all events of [begin, end), sorted.
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    // Declares [begin, end) lost: its events will never be known.
    void lose(TimePoint begin, TimePoint end);

    // To be called once per sampling period of the EMG, with the counts of both electrodes. The result is
    // valid until the next call.
    const ControllerStep& step(TimePoint now, const Emg& emg);
    // Updates the envelope of the EMG without making a step.
    void follow(const Emg& emg);

    // Begins a new session: the decoder starts without history, and the grip state is `operating`.
    void restart(TimePoint now);
    // Begins at `now` without history: the last span that was observed or lost ended at heard_until, nothing
    // is presumed before presumes_from, and `last` stands until something is known.
    void resume_after(TimePoint now, TimePoint heard_until, const Estimate& last,
                      TimePoint presumes_from = scene_start);
    // Replaces the estimate that stands until something is known.
    void correct(const Estimate& last);

    void set_state(GripState state) noexcept;
    GripState state() const noexcept;
    TimePoint heard_until() const noexcept;
    // While packets are in time, a span whose packet would have been delivered by now counts as silent, or as
    // foreseen where link.timing_tolerance_us is, until the next packet. After one that was late or lost
    // nothing is presumed for ten seconds, until this time: in a touch, a span without a packet is then more
    // likely lost than silent, and the silence of all afferents is a release.
    TimePoint presumes_from() const noexcept;
    // How far back an estimate depends on events.
    Duration history() const;
    // Whether the decoder ignores this afferent at present, because it contradicts the others.
    bool left_out(Address address) const;
    const ControllerStep& last_step() const noexcept;
    std::size_t bytes() const;
    // Null if the scene has no read-outs.
    const Readouts* readouts() const noexcept;

    // The whole state on which later steps depend, except the position in the stream of packets.
    struct Snapshot {
        struct State;
        std::shared_ptr<const State> state;
    };
    Snapshot snapshot() const;
    // Restores a snapshot; later steps are bit for bit those that would have followed it. Throws
    // ParameterError if the snapshot is of another scene.
    void resume(const Snapshot& snapshot);

  private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace afferent
