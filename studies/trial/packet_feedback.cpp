#include "afferent/studies/trial/packet_feedback.hpp"

#include <algorithm>

#include "afferent/nodes/channel_parameters.hpp"

namespace afferent {

PacketFeedback::PacketFeedback(const Plan& plan, const PacketLayout& layout)
    : plan_(plan), layout_(layout), order_(plan.timing.overtaking), waiting_(16) {}

void PacketFeedback::begin(std::uint32_t presentation) {
    packetizer_.emplace(layout_);
    if (layout_.acknowledged) way_back_.emplace(way_back_parameters(plan_.scene, presentation));
    intake_.emplace(layout_, plan_.timing.stale);
    order_ = PacketOrder(plan_.timing.overtaking);
    first_ = count_ = 0;
    acted_until_ = scene_start;
}

void PacketFeedback::close(TimePoint deadline, Channel& channel) {
    take_acknowledgements(deadline);
    packetizer_->push(events_before(deadline));
    std::uint64_t sent = packetizer_->events();
    packetizer_->close(deadline, [&](const proto::Envelope& packet) {
        channel.send(deadline, frames_.datagram(packet),
                     static_cast<std::uint32_t>(packetizer_->events() - sent));
        sent = packetizer_->events();
    });
}

void PacketFeedback::take_acknowledgements(TimePoint until) {
    while (way_back_ && way_back_->next_arrival(until))
        if (read_datagram(way_back_->arrive(), answer_, counts_) && answer_.has_acknowledgement())
            packetizer_->acknowledge(answer_.acknowledgement());
}

bool PacketFeedback::arrive(std::span<const std::byte> frame, TimePoint arrived) {
    if (!read_datagram(frame, received_, counts_)) return false;
    const bool waits = order_.hold(received_, intake_->receiver(), wall_time(arrived));
    const bool alive = waits || receive(received_, arrived, arrived);
    receive_held(arrived);
    return alive;
}

void PacketFeedback::receive_held(TimePoint now) {
    while (const PacketOrder::Held* next = order_.next(intake_->receiver(), wall_time(now)))
        receive(next->packet, virtual_time(next->arrived), now);
}

bool PacketFeedback::receive(const proto::Envelope& packet, TimePoint arrived, TimePoint now) {
    const Result<Reception> received =
        intake_->receive(packet, [arrived](TimePoint time) { return arrived - time; });
    if (intake_->receiver().acknowledge(answer_)) way_back_->send(now, frames_.datagram(answer_), 0);
    if (!received) return false;
    const Reception& reception = received.value();
    if (count_ == waiting_.size()) {
        std::rotate(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(first_), waiting_.end());
        first_ = 0;
        waiting_.resize(2 * waiting_.size());
    }
    Waiting& waiting = waiting_[(first_ + count_++) % waiting_.size()];
    waiting.acts = plan_.scene.trial->untimed_events ? now : acts_at(plan_, reception.known.end, now);
    waiting.reception.keep(reception);
    return reception.measured();
}

std::optional<TimePoint> PacketFeedback::wait_ends() const {
    const auto due = order_.due();
    return due ? std::optional(virtual_time(*due)) : std::nullopt;
}

std::optional<TimePoint> PacketFeedback::next_act() const {
    const auto acts = count_ > 0 ? std::optional(waiting_[first_].acts) : std::nullopt;
    const auto ends = wait_ends();
    return acts && ends ? std::min(*acts, *ends) : acts ? acts : ends;
}

// Its events are of the moment at which it acts, and nothing has happened since the one before. What was lost
// is known by its length.
Reception PacketFeedback::without_times(Waiting& waiting) {
    const TimePoint begin = acted_until_;
    const TimePoint last = std::max(waiting.acts, begin);
    acted_until_ = last + Duration(1);
    Reception reception = waiting.reception;
    if (reception.gap) {
        const TimePoint lost_until = std::min(begin + (reception.gap->end - reception.gap->begin), last);
        reception.gap = TimeSpan{begin, lost_until};
    }
    reception.known = {reception.gap ? reception.gap->end : begin, acted_until_};
    reception.presumed_until = acted_until_;
    const std::span<Event> events = waiting.reception.kept_events();
    for (Event& event : events) event.time = last;
    std::ranges::sort(events);
    return reception;
}

void PacketFeedback::act() {
    if (const auto ends = wait_ends(); ends && (count_ == 0 || *ends <= waiting_[first_].acts))
        return receive_held(*ends);
    Waiting& waiting = waiting_[first_];
    take(plan_.scene.trial->untimed_events ? without_times(waiting) : waiting.reception);
    first_ = (first_ + 1) % waiting_.size();
    --count_;
}

}  // namespace afferent
