// A hand's side with what a link adds to it: which packets came too late, when the grip must not close any
// further, and the recording from which a replay comes to the same. Alike in virtual and in real time.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hand_side.hpp"
#include "afferent/nodes/outputs.hpp"

namespace afferent {

class GuardedHand {
  public:
    explicit GuardedHand(std::unique_ptr<HandSide> side, StepOutputs outputs = {})
        : side_(std::move(side)), outputs_(std::move(outputs)) {}

    HandSide& side() noexcept { return *side_; }
    const HandSide& side() const noexcept { return *side_; }
    const StepOutputs& outputs() const noexcept { return outputs_; }

    // Called with the reason when the grip becomes safe.
    std::function<void(const std::string&)> on_safe = [](const auto&) {};

    // Records everything from here on.
    void record(HandRecording recording) { recording_ = std::move(recording); }
    // Nothing follows. The error of what could not be written.
    Result<void> close(TimePoint time);

    // A session: its hello, then where it begins. `begin` begins with a side that has done nothing yet,
    // `restart` goes on with the one that is there.
    void hello(const proto::Hello& hello);
    void begin(TimePoint time);
    void restart(TimePoint time);
    // Another side, in place of the one that is there.
    void replace(std::unique_ptr<HandSide> side) { side_ = std::move(side); }

    // What a packet told, and then the packet itself, with which it is recorded; of a refused packet the
    // packet alone. A packet is late, and counted, if it came after it should have acted.
    void receive(const Reception& reception, PacketReceiver& receiver, TimePoint arrived = scene_start);
    // The same while the hand has not begun: it is recorded, and has no effect.
    void pass_over(const Reception& reception) { stale_ = reception.stale; }
    void received(const proto::Envelope& packet);
    // The peer's last word; what it told of a gap has been received before.
    void bye(const proto::Bye& bye);

    // What the grip may do from here on, and why.
    void follow(GripState state, const std::string& reason);
    GripState state() const noexcept { return state_; }

    // To be called after each step of the side's. No receiver: no session.
    void did(const ControllerStep& step, const PacketReceiver* receiver);

    // How often the grip became frozen, and safe.
    std::uint64_t freezes() const noexcept { return freezes_; }
    std::uint64_t safe_states() const noexcept { return safe_states_; }

  private:
    std::unique_ptr<HandSide> side_;
    StepOutputs outputs_;
    std::optional<HandRecording> recording_;
    GripState state_ = GripState::operating;
    std::uint64_t before_session_ = 0;      // the step that was due at its hello
    std::optional<std::uint64_t> late_at_;  // the step before which a packet acts that came too late
    bool stale_ = false;                    // the packet that is being received
    std::uint64_t freezes_ = 0;
    std::uint64_t safe_states_ = 0;
};

}  // namespace afferent
