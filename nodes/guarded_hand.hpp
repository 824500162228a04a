// A hand's side with what a link adds to it: which packets came too late, when the grip must not close any
// further, and a record of what it does, from which a replay comes to the same. Alike in virtual and in real
// time.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "afferent/nodes/hand_record.hpp"
#include "afferent/nodes/hand_side.hpp"

namespace afferent {

// Waits for nobody: what it tells goes into the records, or is lost. Allocates nothing.
class GuardedHand {
  public:
    // The records outlive it. `state`: what the grip may do until follow() says something else.
    GuardedHand(std::unique_ptr<HandSide> side, HandRecords& records, GripState state = GripState::operating);

    HandSide& side() noexcept { return *side_; }
    const HandSide& side() const noexcept { return *side_; }

    // A session: its hello, then where it begins. `begin` begins with a side that has done nothing yet: the
    // one that is there, or `fresh`, which is exchanged for it. `restart` goes on with the one that is there.
    void hello(proto::Envelope& hello);
    void begin(TimePoint time, std::unique_ptr<HandSide>& fresh);
    void restart(TimePoint time);
    // There is no session any more.
    void session_ended() noexcept { place_ = {}; }

    // What a packet told, and then the packet itself, with which it is recorded; of a refused packet the
    // packet alone. A packet is late, and counted, if it came after it should have acted. `place`: after it.
    void receive(const Reception& reception, const PacketPlace& place, TimePoint arrived = scene_start);
    // The same with the events in a vector, which is exchanged for another.
    void receive(const Reception& reception, const PacketPlace& place, std::vector<Event>& events);
    // Messages are exchanged for others.
    void packet(proto::Envelope& packet);
    // The peer's last word; what it told of a gap has been received before.
    void bye(proto::Envelope& bye);

    // What the grip may do from here on, and why.
    void follow(GripState state, const GripCause& cause);
    GripState state() const noexcept { return state_; }

    // To be called after each step of the side's.
    void did(const ControllerStep& step);

    // How often the grip became frozen, and safe, and how many packets came late.
    std::uint64_t freezes() const noexcept { return freezes_; }
    std::uint64_t safe_states() const noexcept { return safe_states_; }
    std::uint64_t late_packets() const noexcept { return late_packets_; }

  private:
    void received(const Reception& reception, const PacketPlace& place, bool late);
    void tell_message(HandRecord::Kind kind, proto::Envelope& message);
    void tell_state(const GripCause& cause, bool first);

    std::unique_ptr<HandSide> side_;
    HandRecords& records_;
    GripState state_;
    PacketPlace place_;
    bool late_ = false;   // the packet that is being received
    bool stale_ = false;  // the same
    std::uint64_t freezes_ = 0;
    std::uint64_t safe_states_ = 0;
    std::uint64_t late_packets_ = 0;
};

}  // namespace afferent
