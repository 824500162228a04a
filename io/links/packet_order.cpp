#include "afferent/io/links/packet_order.hpp"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

namespace afferent {

bool PacketOrder::hold(const proto::Envelope& packet, const PacketReceiver& receiver, MonotonicTime now) {
    if (longest_wait_ <= Duration::zero()) return false;
    const auto standing = receiver.standing(packet);
    if (!standing || !standing->misses_some) return false;
    if (count_ == held_.size()) held_.emplace_back();
    Held& held = held_[count_++];
    held.packet = packet;
    held.arrived = now;
    held.standing = *standing;
    return true;
}

PacketOrder::Held* PacketOrder::next(const PacketReceiver& receiver, MonotonicTime now) {
    if (count_ == 0) return nullptr;
    const auto waiting = std::span(held_).first(count_);
    const auto sent_before = [](const Held& a, const Held& b) {
        return std::tie(a.standing.end, a.standing.part) < std::tie(b.standing.end, b.standing.part);
    };
    Held& first = *std::min_element(waiting.begin(), waiting.end(), sent_before);
    if (count_ < most && now < *due()) {
        const auto standing = receiver.standing(first.packet);
        if (standing && standing->misses_some) return nullptr;
    }
    Held& last = held_[--count_];
    if (&first != &last) std::swap(first, last);
    return &last;
}

std::optional<MonotonicTime> PacketOrder::due() const {
    if (count_ == 0) return std::nullopt;
    const auto waiting = std::span(held_).first(count_);
    const auto came_before = [](const Held& a, const Held& b) { return a.arrived < b.arrived; };
    return std::min_element(waiting.begin(), waiting.end(), came_before)->arrived + longest_wait_;
}

}  // namespace afferent
