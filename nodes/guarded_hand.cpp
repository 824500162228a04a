#include "afferent/nodes/guarded_hand.hpp"

namespace afferent {

Result<void> GuardedHand::close(TimePoint time) {
    const Result<void> written = outputs_.close();
    if (recording_) {
        AFFERENT_TRY(recording_->close(time, side_->next_step()));
    }
    return written;
}

void GuardedHand::hello(const proto::Hello& hello) {
    before_session_ = side_->next_step();
    if (recording_) recording_->hello(hello, before_session_);
}

void GuardedHand::begin(TimePoint time) {
    side_->begin_at(time);
    if (recording_) recording_->begin(time, true, before_session_);
}

void GuardedHand::restart(TimePoint time) {
    side_->restart(time);
    if (recording_) recording_->begin(time, false, before_session_);
}

void GuardedHand::receive(const Reception& reception, PacketReceiver& receiver, TimePoint arrived) {
    stale_ = reception.stale;
    if (!side_->receive(reception, arrived)) return;
    // A stale packet is counted as such.
    if (!stale_) receiver.count_late();
    late_at_ = side_->next_step();
}

void GuardedHand::received(const proto::Envelope& packet) {
    const auto late_at = std::exchange(late_at_, std::nullopt);
    const bool stale = std::exchange(stale_, false);
    if (recording_) recording_->packet(packet, late_at, stale);
}

void GuardedHand::bye(const proto::Bye& bye) {
    const auto late_at = std::exchange(late_at_, std::nullopt);
    if (recording_) recording_->bye(bye, late_at);
}

void GuardedHand::follow(GripState state, const std::string& reason) {
    if (state == state_) return;
    if (recording_) recording_->grip_state(state, reason, side_->next_step());
    if (state == GripState::frozen) ++freezes_;
    if (state == GripState::safe) {
        ++safe_states_;
        on_safe(reason);
    }
    state_ = state;
    side_->set_state(state);
}

void GuardedHand::did(const ControllerStep& step, const PacketReceiver* receiver) {
    outputs_.take(step);
    if (recording_) recording_->step(step, *side_, receiver);
}

}  // namespace afferent
