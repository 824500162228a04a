// Feedback by the spikes of the scene's neurons: the product's coprocessor and controller.
#pragma once

#include "afferent/engine/coprocessor.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/studies/trial/packet_feedback.hpp"

namespace afferent {

class EventFeedback final : public PacketFeedback {
  public:
    explicit EventFeedback(const Plan& plan);

    void begin(std::uint32_t presentation) override;
    void sense(const Scan& scan) override { coprocessor_.push(scan); }
    const ControllerStep& step(TimePoint now, const Emg& emg, GripState state) override;

  protected:
    std::span<const Event> events_before(TimePoint deadline) override;
    void take(const Reception& reception) override;

  private:
    Coprocessor coprocessor_;
    Controller controller_;
    Controller::Snapshot start_;
};

}  // namespace afferent
