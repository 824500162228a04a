#include "afferent/studies/trial/event_feedback.hpp"

namespace afferent {

EventFeedback::EventFeedback(const Plan& plan)
    : PacketFeedback(plan, packet_layout(plan)),
      coprocessor_(plan),
      controller_(plan),
      start_(controller_.snapshot()) {}

void EventFeedback::begin(std::uint32_t presentation) {
    PacketFeedback::begin(presentation);
    coprocessor_.reset();
    controller_.resume(start_);
}

std::span<const Event> EventFeedback::events_before(TimePoint deadline) {
    return coprocessor_.advance(deadline - Duration(1));
}

void EventFeedback::take(const Reception& reception) { controller_.receive(reception); }

const ControllerStep& EventFeedback::step(TimePoint now, const Emg& emg, GripState state) {
    controller_.set_state(state);
    return controller_.step(now, emg);
}

}  // namespace afferent
