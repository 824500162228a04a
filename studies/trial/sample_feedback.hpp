// Feedback by the grip force itself: the sensors' samples cross the link instead of spikes.
#pragma once

#include <deque>
#include <vector>

#include "afferent/io/wire/frame.hpp"
#include "afferent/io/wire/message_types.hpp"
#include "afferent/studies/trial/feedback.hpp"

namespace afferent {

// At each deadline at which there are new samples, and at least as often as a heartbeat, the last of every
// element goes into one frame of the wire. The estimate is the sum of the newest that have acted, over the
// elements' shares of the grip force.
class SampleFeedback final : public Feedback {
  public:
    explicit SampleFeedback(const Plan& plan);

    void begin(std::uint32_t) override;
    void sense(const Scan& scan) override;
    void close(TimePoint deadline, Channel& channel) override;
    bool arrive(std::span<const std::byte> frame, TimePoint arrived) override;
    std::optional<TimePoint> next_act() const override;
    void act() override;
    const ControllerStep& step(TimePoint now, const Emg& emg, GripState state) override {
        return gain_.step(now, emg, state, estimate_);
    }

  private:
    struct Waiting {
        TimePoint acts;
        double force_n;
    };

    const Plan& plan_;
    double shares_ = 0;
    DirectGain gain_;
    std::vector<double> forces_n_;
    bool fresh_ = false;
    TimePoint sent_at_ = scene_start;
    proto::Envelope sent_;
    FrameWriter frames_;
    proto::Envelope received_;
    FrameCounts counts_;
    TimePoint newest_ = scene_start;  // of the samples that have arrived
    std::deque<Waiting> waiting_;
    Estimate estimate_;
};

// The sum of the shares of all elements, each counted once.
double total_share(const Plan& plan);

}  // namespace afferent
