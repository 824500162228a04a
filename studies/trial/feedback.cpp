#include "afferent/studies/trial/feedback.hpp"

#include "afferent/studies/trial/event_feedback.hpp"
#include "afferent/studies/trial/sample_feedback.hpp"
#include "afferent/studies/trial/send_on_delta.hpp"

namespace afferent {
namespace {

Duration period(const ControllerPlan& plan) { return from_seconds(1 / plan.emg_rate_hz); }

}  // namespace

std::unique_ptr<Feedback> make_feedback(const Plan& plan, Condition::Feed feed) {
    switch (feed) {
        case Condition::Feed::nothing:
            return std::make_unique<NoFeedback>(plan);
        case Condition::Feed::samples:
            return std::make_unique<SampleFeedback>(plan);
        case Condition::Feed::events:
            return std::make_unique<EventFeedback>(plan);
        case Condition::Feed::send_on_delta:
            return std::make_unique<SendOnDeltaFeedback>(plan);
    }
    return nullptr;
}

DirectGain::DirectGain(const ControllerPlan& plan)
    : closing_at_rest_(plan.closing, period(plan)),
      opening_at_rest_(plan.opening, period(plan)),
      closing_(closing_at_rest_),
      opening_(opening_at_rest_),
      control_(plan.control),
      reflexes_(plan.reflexes) {}

void DirectGain::begin() {
    closing_ = closing_at_rest_;
    opening_ = opening_at_rest_;
    reflexes_.restart();
    step_ = {};
}

const ControllerStep& DirectGain::step(TimePoint now, const Emg& emg, GripState state,
                                       const Estimate& estimate) {
    step_.time = now;
    step_.closing_counts = emg.closing_counts;
    step_.effort = {closing_(emg.closing_counts), opening_(emg.opening_counts)};
    step_.estimate = estimate;
    const GripCommand command = control_(estimate, state, step_.effort);
    step_.gain = command.gain;
    step_.command = reflexes_(now, estimate, true, state, command);
    return step_;
}

}  // namespace afferent
