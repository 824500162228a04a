#include "afferent/trial/packet_feedback.hpp"

#include <algorithm>

namespace afferent {

PacketFeedback::PacketFeedback(const Plan& plan, const PacketLayout& layout)
    : plan_(plan), layout_(layout), waiting_(16) {}

void PacketFeedback::begin() {
    packetizer_.emplace(layout_);
    intake_.emplace(layout_, plan_.timing.stale);
    first_ = count_ = 0;
}

void PacketFeedback::close(TimePoint deadline, Channel& channel) {
    packetizer_->push(events_before(deadline));
    std::uint64_t sent = packetizer_->events();
    packetizer_->close(deadline, [&](const proto::Envelope& packet) {
        channel.send(deadline, frames_.datagram(packet),
                     static_cast<std::uint32_t>(packetizer_->events() - sent));
        sent = packetizer_->events();
    });
}

bool PacketFeedback::arrive(std::span<const std::byte> frame, TimePoint arrived) {
    if (!read_datagram(frame, received_, counts_)) return false;
    const Result<Reception> received =
        intake_->receive(received_, [arrived](TimePoint time) { return arrived - time; });
    if (!received) return false;
    const Reception& reception = received.value();
    if (count_ == waiting_.size()) {
        std::rotate(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(first_), waiting_.end());
        first_ = 0;
        waiting_.resize(2 * waiting_.size());
    }
    Waiting& waiting = waiting_[(first_ + count_++) % waiting_.size()];
    waiting.acts = acts_at(plan_, reception.known.end, arrived);
    waiting.reception = reception;
    waiting.events.assign(reception.events.begin(), reception.events.end());
    waiting.reception.events = {};
    return reception.measured();
}

std::optional<TimePoint> PacketFeedback::next_act() const {
    return count_ > 0 ? std::optional(waiting_[first_].acts) : std::nullopt;
}

void PacketFeedback::act() {
    Waiting& waiting = waiting_[first_];
    Reception reception = waiting.reception;
    reception.events = waiting.events;
    take(reception);
    first_ = (first_ + 1) % waiting_.size();
    --count_;
}

}  // namespace afferent
