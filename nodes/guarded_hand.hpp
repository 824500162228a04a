// A hand's end with what a link adds to it: which packets came too late, when the grip must not close any
// further, and a record of everything, from which a replay gives the same result. The same in virtual and in
// real time.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "afferent/nodes/hand_end.hpp"
#include "afferent/nodes/hand_record.hpp"

namespace afferent {

// Waits for nobody: a record that finds no room is lost. Allocates nothing.
class GuardedHand {
  public:
    // The records outlive it. `state` holds until follow() sets another.
    GuardedHand(std::unique_ptr<HandEnd> link_end, HandRecords& records,
                GripState state = GripState::operating);

    HandEnd& link_end() noexcept { return *link_end_; }
    const HandEnd& link_end() const noexcept { return *link_end_; }

    // A session: its hello, then where in the scene it begins. `begin` starts with an end that has done
    // nothing yet: `fresh`, if it is not null, is swapped for the hand's. `restart` goes on with the hand's
    // end.
    void hello(proto::Envelope& hello);
    void begin(TimePoint time, std::unique_ptr<HandEnd>& fresh);
    void restart(TimePoint time);
    // The session is over.
    void session_ended() noexcept { offset_ = {}; }

    // For a packet, what it told and then the packet itself, with which it is recorded; for a refused packet,
    // the packet alone. A packet is late, and counted, if it came after it should have acted. `offset` is the
    // offset after it.
    void receive(const Reception& reception, const PacketOffset& offset, TimePoint arrived = scene_start);
    // The same, swapped for another: nothing is copied or allocated.
    void receive(KeptReception&& reception, const PacketOffset& offset);
    // Messages are swapped for others.
    void packet(proto::Envelope& packet);
    void refused(proto::Envelope& packet);
    // The peer's bye; a gap that it told of has been received before.
    void bye(proto::Envelope& bye);

    // What the grip may do from here on, and why.
    void follow(GripState state, const GripCause& cause);
    GripState state() const noexcept { return state_; }

    // To be called after each step of the end.
    void did(const ControllerStep& step);

    // How often the grip became frozen, and safe, and how many packets came late.
    std::uint64_t freezes() const noexcept { return freezes_; }
    std::uint64_t safe_states() const noexcept { return safe_states_; }
    std::uint64_t late_packets() const noexcept { return late_packets_; }

  private:
    void received(bool stale, const PacketOffset& offset, bool late);
    void tell_message(HandRecord::Kind kind, proto::Envelope& message, bool refused = false);
    void tell_state(const GripCause& cause, bool first);

    std::unique_ptr<HandEnd> link_end_;
    HandRecords& records_;
    GripState state_;
    PacketOffset offset_;
    bool late_ = false;   // the packet that is being received
    bool stale_ = false;  // the same
    std::uint64_t freezes_ = 0;
    std::uint64_t safe_states_ = 0;
    std::uint64_t late_packets_ = 0;
};

}  // namespace afferent
