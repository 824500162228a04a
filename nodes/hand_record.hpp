// What a hand has done, in order, for the writer.
#pragma once

#include <cstdint>
#include <vector>

#include "afferent/io/wire/message_types.hpp"
#include "afferent/nodes/hand_end.hpp"
#include "afferent/runtime/grip_guard.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {

// How far a session's packets have come: in packet spans since the start of the scene, and how many events
// are delivered or known to be lost.
struct PacketOffset {
    std::uint64_t spans = 0;
    std::uint64_t counted_events = 0;
};

struct HandRecord {
    enum class Kind { hello, begin, packet, bye, grip_state, step };

    Kind kind = Kind::step;
    std::uint64_t number = 0;  // counts all records, lost ones too
    std::uint64_t step = 0;    // the step that was due next: HandEnd::next_step()

    proto::Envelope message;  // hello, packet, bye
    bool late = false;        // packet, bye: it acted before the step `step`, not at its regular time
    bool stale = false;       // packet: it was too old to be used
    bool refused = false;     // packet: nothing was received of it
    TimePoint time;           // begin
    bool new_hand = false;    // begin: with an end that has done nothing yet
    GripState state{};        // grip_state
    GripCause cause;          // grip_state
    bool first = false;       // grip_state: the hand begins with it
    ControllerStep done{};    // step
    HandEnd::Memory memory;   // step: after it
    PacketOffset offset;      // step
};

// From the hand to the writer. A record that finds no room is lost; the numbers of the next ones show it.
class HandRecords {
  public:
    // `room` records, each with room for such a step (step_with_room).
    HandRecords(std::size_t room, ControllerStep step) : ring_(room, with(std::move(step))) {}

    // For the hand: the record to fill in and then push; null if there is no room.
    HandRecord* make(HandRecord::Kind kind, std::uint64_t step) noexcept {
        HandRecord* const record = ring_.free_slot();
        if (record) {
            record->kind = kind;
            record->number = made_;
            record->step = step;
        }
        ++made_;
        if (!record && kind == HandRecord::Kind::step) ++lost_steps_;
        return record;
    }
    void push() noexcept { ring_.push(); }
    // How many there have been, lost ones included. Other threads may ask once the hand has stopped.
    std::uint64_t made() const noexcept { return made_; }

    // Steps that found no room. For the hand's thread.
    std::uint64_t lost_steps() const noexcept { return lost_steps_; }

    // For the writer.
    const HandRecord* next() noexcept { return ring_.next(); }
    void pop() noexcept { ring_.pop(); }
    // Records that wait.
    std::size_t waiting() const noexcept { return ring_.waiting(); }

  private:
    static HandRecord with(ControllerStep step) {
        HandRecord record;
        record.done = std::move(step);
        return record;
    }

    SlotRing<HandRecord> ring_;
    std::uint64_t made_ = 0;
    std::uint64_t lost_steps_ = 0;
};

}  // namespace afferent
