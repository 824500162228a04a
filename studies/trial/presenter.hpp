// Presents objects one after the other: everything that one thread needs for it, built once.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "afferent/hand/prosthesis_motor.hpp"
#include "afferent/hand/surface_emg.hpp"
#include "afferent/hand/trial_object.hpp"
#include "afferent/hand/trial_user.hpp"
#include "afferent/io/links/channel.hpp"
#include "afferent/nodes/emg.hpp"
#include "afferent/nodes/patch_sensors.hpp"
#include "afferent/runtime/grip_guard.hpp"
#include "afferent/studies/trial/feedback.hpp"
#include "afferent/studies/trial/presentation.hpp"
#include "afferent/studies/trial/sample_radio.hpp"

namespace afferent {

class Presenter {
  public:
    // The plan outlives it. With recorded EMG the user's effort is that of the recording.
    Presenter(const Plan& plan, Condition::Feed feed, const EmgTable& recorded = {});

    // The presentation of that number, whatever was presented before. `trace`, where it is not null, gets its
    // steps.
    Presentation present(std::uint32_t number, std::vector<TraceStep>* trace = nullptr);

  private:
    void begin(std::uint32_t number);
    // Everything that comes before the controller's step at that time.
    void carry_until(TimePoint now);
    void place_sensors();
    void take_scan();
    void hand_over();
    void move(TimePoint now);
    void see(double time_s, double force_n);
    Emg emg(std::uint64_t k, double time_s);
    void notice_weakness(double gain);
    void watch_telling(double time_s, const Estimate& estimate);
    void watch_answer(double time_s, const ControllerStep& step);
    void watch_reaction(double time_s, const ControllerStep& step);
    bool pulse_begins(const ControllerStep& step);
    bool is_over(double time_s);
    void conclude(double time_s);

    const Plan& plan_;
    const scene::Trial& trial_;
    std::unique_ptr<Feedback> feedback_;
    bool has_link_;
    ChannelParameters channel_parameters_;
    Channel channel_;
    SampleRadio radio_;
    TrialUser user_;
    TrialObjects objects_;
    SurfaceEmg closing_;
    SurfaceEmg opening_;
    std::optional<EmgSource> recorded_;
    ProsthesisMotor motor_;

    // The state of the presentation under way.
    Presentation result_;
    TrialUser::Intent intent_{};
    TrialUser::Seen seen_;
    TrialObject object_;
    GripGuard guard_;
    std::vector<double> stated_shares_;  // by element
    std::vector<PatchPlan> felt_;        // patches with elements, with the shares of this presentation
    std::vector<PatchSensors> sensors_;
    std::vector<TimePoint> next_scan_;
    TimePoint deadline_;
    TimePoint now_;
    double command_ = 0;
    double untouched_gain_ = 1;  // of the last step before the contact
    Estimate untouched_;         // the highest force and rate before the contact
    double effort_ = 0;
    bool pulses_ = false;
    double follows_;  // the part of the way to the aimed effort that a step goes
    // The gain of the last steps, and the highest of them when the slip began.
    static constexpr std::size_t remembered_steps = 100;
    std::array<double, remembered_steps> gains_{};
    std::size_t steps_ = 0;
    double highest_gain_ = 0;
};

}  // namespace afferent
