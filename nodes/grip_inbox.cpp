#include "afferent/nodes/grip_inbox.hpp"

#include <utility>

namespace afferent {
namespace {

// Kept free for inputs that are not packets.
constexpr std::size_t reserved_slots = 8;

}  // namespace

GripInbox::GripInbox(std::size_t room, bool keeps_messages)
    : ring_(room + reserved_slots), keeps_messages_(keeps_messages) {}

void GripInbox::opened(MonotonicTime now, const proto::Hello& hello) {
    GripInput input;
    input.kind = GripInput::Kind::opened;
    input.at = now;
    *input.message.mutable_hello() = hello;
    pass_on(std::move(input));
}

void GripInbox::begin(MonotonicTime now, TimePoint time, std::unique_ptr<HandEnd> fresh) {
    GripInput input;
    input.kind = GripInput::Kind::begin;
    input.at = now;
    input.time = time;
    input.link_end = std::move(fresh);
    pass_on(std::move(input));
}

void GripInbox::restart(MonotonicTime now) {
    GripInput input;
    input.kind = GripInput::Kind::restart;
    input.at = now;
    pass_on(std::move(input));
}

void GripInbox::ended(MonotonicTime now, const std::optional<proto::Bye>& bye) {
    finish_reception();
    GripInput input;
    input.kind = GripInput::Kind::ended;
    input.at = now;
    input.has_message = bye.has_value();
    if (bye) *input.message.mutable_bye() = *bye;
    pass_on(std::move(input));
    lost_.forget();
}

void GripInbox::steer(MonotonicTime now, std::optional<Duration> ahead) {
    GripInput input;
    input.kind = GripInput::Kind::steer;
    input.at = now;
    input.ahead = ahead;
    pass_on(std::move(input));
}

void GripInbox::acknowledged(MonotonicTime now) {
    GripInput input;
    input.kind = GripInput::Kind::acknowledged;
    input.at = now;
    pass_on(std::move(input));
}

void GripInbox::stop() { pass_on({}); }

void GripInbox::pass_on(GripInput&& input) {
    waiting_.push_back(std::move(input));
    flush();
}

void GripInbox::flush() {
    while (!waiting_.empty()) {
        GripInput* const slot = ring_.free_slot();
        if (!slot) return;
        *slot = std::move(waiting_.front());
        waiting_.pop_front();
        ring_.push();
    }
}

GripInput* GripInbox::slot_for_packet() {
    // Asked once: the loop may make room at any time, and a packet must not overtake what waits.
    const bool fits = ring_.room() > waiting_.size() + reserved_slots;
    flush();
    return fits ? ring_.free_slot() : nullptr;
}

void GripInbox::receive(const Reception& reception, const PacketOffset& offset, MonotonicTime now) {
    finish_reception();
    receiving_ = slot_for_packet();
    dropping_ = !receiving_;
    if (dropping_) {
        ++dropped_;
        return lost_.add(reception);
    }
    receiving_->kind = GripInput::Kind::reception;
    receiving_->at = now;
    receiving_->reception.keep(reception);
    lost_.tell(receiving_->reception);
    receiving_->offset = offset;
    receiving_->has_message = false;
}

void GripInbox::packet(const proto::Envelope& packet) {
    if (std::exchange(dropping_, false)) return;
    GripInput* slot = receiving_;
    if (!slot && keeps_messages_) {
        slot = slot_for_packet();
        if (slot) slot->kind = GripInput::Kind::refused;
    }
    if (!slot) return;
    slot->has_message = keeps_messages_;
    if (keeps_messages_) slot->message = packet;
    receiving_ = nullptr;
    ring_.push();
}

void GripInbox::finish_reception() {
    if (std::exchange(receiving_, nullptr)) ring_.push();
}

}  // namespace afferent
