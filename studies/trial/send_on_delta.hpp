// Feedback by onset and offset events: one for each change of an element's force.
#pragma once

#include <vector>

#include "afferent/studies/trial/packet_feedback.hpp"

namespace afferent {

// After Osborn et al. (IEEE Trans. Haptics 2016). An element that last told the level L sends, at a sample F,
// an onset event and L := L + delta for as long as F − L >= delta, or offset events and L := L − delta while
// L − F >= delta. In the hand each element's level is the sum of its events; and a leaky integrate-and-fire
// unit detects the contact:
//
//     dv/dt = −v/tau,  v := v + 1 at each onset event;  v >= threshold: contact, v := 0
//
// Contact lasts until all levels are back at 0. The estimate is the sum of the levels over the shares of the
// elements while there is contact, and 0 otherwise. The gain takes it as it takes any other; gain.pulse has
// the closing pulses of that experiment.
//
// Nothing is sent twice, so a lost packet leaves its error in the levels, as it does in any link that sends
// differences.
class SendOnDeltaFeedback final : public PacketFeedback {
  public:
    // The plan's scene has a trial.
    explicit SendOnDeltaFeedback(const Plan& plan);

    void begin(std::uint32_t presentation) override;
    void sense(const Scan& scan) override;
    const ControllerStep& step(TimePoint now, const Emg& emg, GripState state) override {
        return gain_.step(now, emg, state, estimate_);
    }

  protected:
    std::span<const Event> events_before(TimePoint deadline) override;
    void take(const Reception& reception) override;

  private:
    static constexpr Address onset(Address element) noexcept { return 2 * element; }
    void count(const Event& event);

    scene::SendOnDelta parameters_;
    double shares_;
    DirectGain gain_;
    // In units of delta.
    std::vector<std::int32_t> sent_levels_;
    std::vector<std::int32_t> levels_;
    std::vector<Event> events_;  // not given yet
    std::vector<Event> given_;
    double potential_ = 0;
    TimePoint potential_at_ = scene_start;
    bool contact_ = false;
    Estimate estimate_;
};

}  // namespace afferent
