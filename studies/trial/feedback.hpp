// What stands between sensors and motor in a trial: under each condition something else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "afferent/engine/controller.hpp"
#include "afferent/io/links/channel.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/scan.hpp"
#include "afferent/scene/plan.hpp"
#include "afferent/studies/trial/condition.hpp"

namespace afferent {

// The times of all calls but act() do not decrease. After begin() everything is as at the first one of that
// presentation.
class Feedback {
  public:
    virtual ~Feedback() = default;

    virtual void begin(std::uint32_t presentation) = 0;

    // The coprocessor's end: what the sensors of one patch read; and the end of a packet's span, by which
    // what is known goes onto the link.
    virtual void sense(const Scan& scan) = 0;
    virtual void close(TimePoint deadline, Channel& channel) = 0;

    // The hand's end: a frame, and whether it was a sign of life; when the next frame's content acts, and its
    // acting; and the controller's step.
    virtual bool arrive(std::span<const std::byte> frame, TimePoint arrived) = 0;
    virtual std::optional<TimePoint> next_act() const = 0;
    virtual void act() = 0;
    virtual const ControllerStep& step(TimePoint now, const Emg& emg, GripState state) = 0;
};

// The plan outlives it, and has a controller and a layout of packets.
std::unique_ptr<Feedback> make_feedback(const Plan& plan, Condition::Feed feed);

// When what was measured up to `end` acts in the hand.
inline TimePoint acts_at(const Plan& plan, TimePoint end, TimePoint arrived) {
    return std::max(end + plan.timing.delivery, arrived);
}

// A controller's step where no decoder gives the estimate: the same envelopes, the same gain.
class DirectGain {
  public:
    explicit DirectGain(const ControllerPlan& plan);
    void begin();
    const ControllerStep& step(TimePoint now, const Emg& emg, GripState state, const Estimate& estimate);

  private:
    EmgEnvelope closing_at_rest_;
    EmgEnvelope opening_at_rest_;
    EmgEnvelope closing_;
    EmgEnvelope opening_;
    EmgControl control_;
    Reflexes reflexes_;
    ControllerStep step_{};
};

// No feedback: the estimate stays 0 and the gain 1.
class NoFeedback final : public Feedback {
  public:
    explicit NoFeedback(const Plan& plan) : gain_(*plan.controller) {}

    void begin(std::uint32_t) override { gain_.begin(); }
    void sense(const Scan&) override {}
    void close(TimePoint, Channel&) override {}
    bool arrive(std::span<const std::byte>, TimePoint) override { return false; }
    std::optional<TimePoint> next_act() const override { return std::nullopt; }
    void act() override {}
    // Without a link nothing can be wrong with it.
    const ControllerStep& step(TimePoint now, const Emg& emg, GripState) override {
        return gain_.step(now, emg, GripState::operating, {});
    }

  private:
    DirectGain gain_;
};

}  // namespace afferent
