#include "afferent/nodes/guarded_hand.hpp"

namespace afferent {

GuardedHand::GuardedHand(std::unique_ptr<HandEnd> link_end, HandRecords& records, GripState state)
    : link_end_(std::move(link_end)), records_(records), state_(state) {
    link_end_->set_state(state);
    if (state != GripState::operating) tell_state({}, true);
}

void GuardedHand::hello(proto::Envelope& hello) {
    offset_ = {};
    tell_message(HandRecord::Kind::hello, hello);
}

// An end that begins or restarts is operating by default, whatever the grip may do: its state is set again.
void GuardedHand::begin(TimePoint time, std::unique_ptr<HandEnd>& fresh) {
    if (HandRecord* const record = records_.make(HandRecord::Kind::begin, link_end_->next_step())) {
        record->time = time;
        record->new_hand = true;
        records_.push();
    }
    if (fresh) link_end_.swap(fresh);
    link_end_->begin_at(time);
    link_end_->set_state(state_);
}

void GuardedHand::restart(TimePoint time) {
    if (HandRecord* const record = records_.make(HandRecord::Kind::begin, link_end_->next_step())) {
        record->time = time;
        record->new_hand = false;
        records_.push();
    }
    link_end_->restart(time);
    link_end_->set_state(state_);
}

void GuardedHand::receive(const Reception& reception, const PacketOffset& offset, TimePoint arrived) {
    received(reception.stale, offset, link_end_->receive(reception, arrived));
}

void GuardedHand::receive(KeptReception&& reception, const PacketOffset& offset) {
    const bool stale = reception.stale;
    received(stale, offset, link_end_->receive(std::move(reception), scene_start));
}

void GuardedHand::received(bool stale, const PacketOffset& offset, bool late) {
    offset_ = offset;
    stale_ = stale;
    late_ = late;
    // A stale packet is counted as stale only.
    if (late && !stale_) ++late_packets_;
}

void GuardedHand::packet(proto::Envelope& packet) { tell_message(HandRecord::Kind::packet, packet); }

void GuardedHand::refused(proto::Envelope& packet) { tell_message(HandRecord::Kind::packet, packet, true); }

void GuardedHand::bye(proto::Envelope& bye) { tell_message(HandRecord::Kind::bye, bye); }

void GuardedHand::tell_message(HandRecord::Kind kind, proto::Envelope& message, bool refused) {
    const bool late = std::exchange(late_, false);
    const bool stale = std::exchange(stale_, false);
    HandRecord* const record = records_.make(kind, link_end_->next_step());
    if (!record) return;
    record->message.Swap(&message);
    record->late = late;
    record->stale = stale;
    record->refused = refused;
    records_.push();
}

void GuardedHand::follow(GripState state, const GripCause& cause) {
    if (state == state_) return;
    state_ = state;
    link_end_->set_state(state);
    if (state == GripState::frozen) ++freezes_;
    if (state == GripState::safe) ++safe_states_;
    tell_state(cause, false);
}

void GuardedHand::tell_state(const GripCause& cause, bool first) {
    HandRecord* const record = records_.make(HandRecord::Kind::grip_state, link_end_->next_step());
    if (!record) return;
    record->state = state_;
    record->cause = cause;
    record->first = first;
    records_.push();
}

void GuardedHand::did(const ControllerStep& step) {
    HandRecord* const record = records_.make(HandRecord::Kind::step, link_end_->next_step());
    if (!record) return;
    record->done = step;
    record->memory = link_end_->memory();
    record->offset = offset_;
    records_.push();
}

}  // namespace afferent
