#include "afferent/nodes/guarded_hand.hpp"

namespace afferent {

GuardedHand::GuardedHand(std::unique_ptr<HandSide> side, HandRecords& records, GripState state)
    : side_(std::move(side)), records_(records), state_(state) {
    side_->set_state(state);
    if (state != GripState::operating) tell_state({}, true);
}

void GuardedHand::hello(proto::Envelope& hello) {
    place_ = {};
    tell_message(HandRecord::Kind::hello, hello);
}

// A side that begins or restarts is operating by default, whatever the grip may do: its state is set again.
void GuardedHand::begin(TimePoint time, std::unique_ptr<HandSide>& fresh) {
    if (HandRecord* const record = records_.make(HandRecord::Kind::begin, side_->next_step())) {
        record->time = time;
        record->new_hand = true;
        records_.push();
    }
    if (fresh) side_.swap(fresh);
    side_->begin_at(time);
    side_->set_state(state_);
}

void GuardedHand::restart(TimePoint time) {
    if (HandRecord* const record = records_.make(HandRecord::Kind::begin, side_->next_step())) {
        record->time = time;
        record->new_hand = false;
        records_.push();
    }
    side_->restart(time);
    side_->set_state(state_);
}

void GuardedHand::receive(const Reception& reception, const PacketPlace& place, TimePoint arrived) {
    received(reception, place, side_->receive(reception, arrived));
}

void GuardedHand::receive(const Reception& reception, const PacketPlace& place, std::vector<Event>& events) {
    received(reception, place, side_->receive(reception, events, scene_start));
}

void GuardedHand::received(const Reception& reception, const PacketPlace& place, bool late) {
    place_ = place;
    stale_ = reception.stale;
    late_ = late;
    // A stale packet is counted as stale only.
    if (late && !stale_) ++late_packets_;
}

void GuardedHand::packet(proto::Envelope& packet) { tell_message(HandRecord::Kind::packet, packet); }

void GuardedHand::bye(proto::Envelope& bye) { tell_message(HandRecord::Kind::bye, bye); }

void GuardedHand::tell_message(HandRecord::Kind kind, proto::Envelope& message) {
    const bool late = std::exchange(late_, false);
    const bool stale = std::exchange(stale_, false);
    HandRecord* const record = records_.make(kind, side_->next_step());
    if (!record) return;
    record->message.Swap(&message);
    record->late = late;
    record->stale = stale;
    records_.push();
}

void GuardedHand::follow(GripState state, const GripCause& cause) {
    if (state == state_) return;
    state_ = state;
    side_->set_state(state);
    if (state == GripState::frozen) ++freezes_;
    if (state == GripState::safe) ++safe_states_;
    tell_state(cause, false);
}

void GuardedHand::tell_state(const GripCause& cause, bool first) {
    HandRecord* const record = records_.make(HandRecord::Kind::grip_state, side_->next_step());
    if (!record) return;
    record->state = state_;
    record->cause = cause;
    record->first = first;
    records_.push();
}

void GuardedHand::did(const ControllerStep& step) {
    HandRecord* const record = records_.make(HandRecord::Kind::step, side_->next_step());
    if (!record) return;
    record->done = step;
    record->memory = side_->memory();
    record->place = place_;
    records_.push();
}

}  // namespace afferent
