// The hand controller's end of a scene: decodes events, drives the gain, moves the hand where it is
// simulated.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "afferent/engine/controller.hpp"
#include "afferent/hand/gripper.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/nodes/emg.hpp"
#include "afferent/nodes/sample_source.hpp"
#include "afferent/runtime/event_queue.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// Does one thing after another: the controller steps at the EMG's rate, packets act when they have been
// delivered, and, where the samples come from this end, scans are taken for the coprocessor.
class HandEnd {
  public:
    using OnStep = std::function<void(const ControllerStep&)>;
    using OnScan = std::function<void(const Scan&)>;

    // Opens the tables that are on this end; `emg` is read in place of the table of EMG.
    static Result<std::unique_ptr<HandEnd>> open(const Plan& plan, std::optional<EmgTable> emg = {});
    // For a replay: with the EMG that was recorded, and without samples, which nobody needs.
    static std::unique_ptr<HandEnd> replaying(const Plan& plan, EmgTable emg);

    // Passes on the steps of another controller, which receives the same packets: `other` is the plan of the
    // same scene with another decoder, and outlives this. The hand moves as it does without. To be called
    // before anything is done.
    void tell_steps_of(const Plan& other);

    // Begins in the middle of the scene. To be called before anything is done.
    void begin_at(TimePoint time);

    // Everything needed to go on after a step, but for the spikes of the decoder's window.
    struct Memory {
        TimePoint time;            // of the last step
        std::uint64_t first_step;  // with which the EMG envelope began
        std::uint64_t next_step;
        TimePoint heard_until;
        TimePoint presumes_from;
        Estimate estimate;
        double command;
        Gripper::State gripper;
        GripState state;
    };
    Memory memory() const;
    // Goes on from there, with no packet waiting to act. To be called before anything is done.
    void resume(const Memory& memory);
    // Replaces what depends on a decoder that was resumed without the spikes of its window.
    void correct(const Memory& memory);

    // The next thing due; scans come after steps of the same time.
    Due next();
    // Does what is due next. False: a scan was refused, source()->refusal().
    bool do_next(const OnStep& on_step, const OnScan& on_scan);

    // Takes what a packet told, or the events of a span handed over in this process. It acts `delivery` after
    // the end of its span, or at once if it arrives later than that. Returns whether it was late.
    bool receive(const Reception& reception, TimePoint arrived = scene_start);
    // The same, swapped for another: nothing is copied or allocated.
    bool receive(KeptReception&& reception, TimePoint arrived);
    // Makes room for so many packets to wait. When more are received, the room grows.
    void make_room(std::size_t packets);
    bool has_room() const noexcept { return waiting_ < arrivals_.size(); }
    // A new session: the decoder starts over, and knows nothing of before.
    void restart(TimePoint now);
    void set_state(GripState state) noexcept {
        each_controller([state](Controller& controller) { controller.set_state(state); });
    }
    GripState state() const noexcept { return controller_ ? controller_->state() : GripState::operating; }
    // Null where nobody reads the estimate: then there are no steps.
    const Controller* controller() const noexcept { return controller_ ? &*controller_ : nullptr; }

    // Null where the hand is not simulated.
    const Gripper* gripper() const noexcept { return gripper_ ? &*gripper_ : nullptr; }

    TimePoint now() const noexcept { return now_; }
    // The number of the step that is due next: step k is k periods of the EMG after the scene's start.
    std::uint64_t next_step() const noexcept { return steps_; }
    TimePoint next_step_time() const;
    const EmgTable& emg() const noexcept { return emg_.table(); }
    // What people should know of where the EMG came from. To be called before anything is done, or after.
    const std::vector<std::string>& said_of_emg() const noexcept { return emg_.said(); }
    const ControllerStep& last_step() const noexcept { return step_; }
    SampleSource* source() const noexcept { return source_.get(); }
    // From here on no scan is due.
    void stop_scans() noexcept { scans_ = false; }

  private:
    HandEnd(const Plan& plan, EmgSource emg);
    // Calls f for the controllers that there are: none, that of the hand, or that and the other.
    template <class F>
    void each_controller(const F& f) {
        if (controller_) f(*controller_);
        if (other_) f(*other_);
    }
    void step();
    void tell_true_forces(ControllerStep& step) const;
    bool is_late(const Reception& reception, TimePoint arrived) const;
    KeptReception& next_arrival(const Reception& reception, TimePoint arrived);

    const Plan& plan_;
    EmgSource emg_;
    std::optional<Controller> controller_;
    std::optional<Controller> other_;  // whose steps are told
    std::optional<Gripper> gripper_;
    std::unique_ptr<SampleSource> source_;
    bool scans_ = true;
    EventQueue queue_;
    TimePoint now_ = scene_start;
    std::uint64_t first_step_ = 0;
    std::uint64_t steps_ = 0;
    ControllerStep step_{};
    ControllerStep other_step_{};
    bool stepped_ = false;
    // A ring of packets that wait to act; they act in the order in which they came.
    std::vector<KeptReception> arrivals_;
    std::size_t first_arrival_ = 0;
    std::size_t waiting_ = 0;
};

}  // namespace afferent
