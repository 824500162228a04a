#include "afferent/studies/trial/presenter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/hand/random.hpp"
#include "afferent/nodes/channel_parameters.hpp"
#include "afferent/studies/trial/felt_shares.hpp"

namespace afferent {
namespace {

// What the fingers have of the object: further down there is nothing left to hold.
constexpr double longest_slip_mm = 20;
// A command that is lower by less than this is no answer to a contact.
constexpr double answering_command = 0.01;
// A command that is higher by less than this is no pulse.
constexpr double pulsing_command = 0.01;
// A rise of the gain that no longer is a flicker of the estimate.
constexpr double reaction_gain = 0.01;

// The command that the EMG asks for under a gain.
double asked(const Effort& effort, double gain) {
    const auto within_1 = [](double part) { return std::clamp(part, 0.0, 1.0); };
    return gain * within_1(effort.closing) - within_1(effort.opening);
}

GripGuard new_guard(const Plan& plan) {
    return GripGuard::within_session({.freeze = plan.timing.freeze, .safe = plan.timing.safe},
                                     MonotonicTime());
}

}  // namespace

Presenter::Presenter(const Plan& plan, Condition::Feed feed, const EmgTable& recorded)
    : plan_(plan),
      trial_(*plan.scene.trial),
      feedback_(make_feedback(plan, feed)),
      has_link_(feed != Condition::Feed::nothing),
      channel_parameters_(channel_parameters(plan.scene)),
      channel_(channel_parameters_),
      radio_(from_milliseconds(trial_.connection_interval_ms), plan.elements, plan.scene.seed),
      user_(trial_.user, trial_.motor.force_limit_n, plan.scene.seed),
      objects_{trial_.object, trial_.slippery},
      closing_(trial_.emg, plan.scene.hand.emg_rate_hz, plan.scene.seed, Stream::closing_emg),
      opening_(trial_.emg, plan.scene.hand.emg_rate_hz, plan.scene.seed, Stream::opening_emg),
      motor_(trial_.motor),
      object_({}),
      guard_(new_guard(plan)),
      follows_(-std::expm1(-1000 / (plan.scene.hand.emg_rate_hz * trial_.user.contraction_ms))) {
    if (!recorded.times.empty()) recorded_ = EmgSource::of(plan.scene, recorded);
    for (const PatchPlan& patch : plan.patches) {
        if (!patch.owns_elements) continue;
        felt_.push_back(patch);
        // The radio is the delay that the sensors tell of.
        if (radio_.in_use()) felt_.back().sensor.delay_ms = 0;
        stated_shares_.insert(stated_shares_.end(), patch.share.begin(), patch.share.end());
    }
    sensors_.reserve(felt_.size());
    next_scan_.resize(felt_.size());
}

void Presenter::begin(std::uint32_t number) {
    result_ = {};
    result_.number = number;
    TrialObject::Parameters object = objects_.object(plan_.scene.seed, number);
    object.lift_mm_per_s = trial_.user.lift_mm_per_s;
    object_ = TrialObject(object);
    result_.slippery = objects_.is_slippery(plan_.scene.seed, number);
    intent_ = user_.intent(number, result_.slippery ? trial_.slippery.aim_factor : 1);
    seen_ = {};
    result_.breaking_force_n = object_.parameters().breaking_force_n;
    result_.stiffness_n_per_mm = object_.parameters().stiffness_n_per_mm;
    result_.weight_n = object_.parameters().weight_n;
    result_.aimed_force_n = intent_.aimed_force_n;
    closing_.begin(number);
    opening_.begin(number);
    if (recorded_) recorded_->restart();
    motor_.reset();
    feedback_->begin(number);
    // Any presentation can be repeated by itself.
    channel_parameters_.seed = random_seed(plan_.scene.seed, Stream::trial_radio, number);
    channel_ = Channel(channel_parameters_);
    radio_.begin(number);
    guard_ = new_guard(plan_);
    place_sensors();
    std::fill(next_scan_.begin(), next_scan_.end(), scene_start);
    deadline_ = scene_start + plan_.timing.span;
    now_ = scene_start;
    command_ = effort_ = 0;
    pulses_ = false;
    untouched_gain_ = 1;
    untouched_ = {};
    gains_.fill(1);
    steps_ = 0;
}

void Presenter::place_sensors() {
    const auto felt = felt_shares(trial_.sensing, stated_shares_, plan_.scene.seed, result_.number);
    auto next = felt.begin();
    sensors_.clear();
    for (PatchPlan& patch : felt_) {
        std::copy_n(next, patch.share.size(), patch.share.begin());
        next += static_cast<std::ptrdiff_t>(patch.share.size());
        sensors_.emplace_back(patch, random_seed(plan_.scene.seed, Stream::sensor_noise, result_.number));
    }
}

Presentation Presenter::present(std::uint32_t number, std::vector<TraceStep>* trace) {
    begin(number);
    const double rate_hz = plan_.scene.hand.emg_rate_hz;
    for (std::uint64_t k = 0;; ++k) {
        const TimePoint now = sample_time(k, rate_hz);
        const double time_s = seconds(now);
        if (has_link_) carry_until(now);
        move(now);
        const double force_n = object_.force_n(motor_.state().position_mm);
        see(time_s, force_n);
        if (is_over(time_s)) {
            conclude(time_s);
            return result_;
        }
        const Emg emg = this->emg(k, time_s);
        const GripState state = has_link_ ? guard_.state(wall_time(now)) : GripState::operating;
        if (state == GripState::safe) result_.safe_state = true;
        const ControllerStep& step = feedback_->step(now, emg, state);
        command_ = step.command;
        notice_weakness(step.gain);
        watch_telling(time_s, step.estimate);
        watch_answer(time_s, step);
        watch_reaction(time_s, step);
        if (trace)
            trace->push_back(
                {time_s, force_n, step.estimate.force_n, step.gain, step.effort.closing, command_});
    }
}

// What the electrodes read at the k-th step.
Emg Presenter::emg(std::uint64_t k, double time_s) {
    if (recorded_) return recorded_->sample(k);
    effort_ += follows_ * (user_.aimed_effort(intent_, time_s, seen_) - effort_);
    return {closing_.counts(effort_), opening_.counts(0)};
}

// In the order of runtime/event_queue.hpp: a packet closes, what arrives acts, the hand steps, its sensors
// sample.
void Presenter::carry_until(TimePoint now) {
    for (;;) {
        const TimePoint scan = *std::min_element(next_scan_.begin(), next_scan_.end());
        const TimePoint connection = radio_.in_use() ? radio_.next_connection() : TimePoint::max();
        const TimePoint other = std::min({deadline_, scan, connection, now});
        const TimePoint arrival = channel_.next_arrival(other).value_or(TimePoint::max());
        const TimePoint act = feedback_->next_act().value_or(TimePoint::max());
        const TimePoint first = std::min({other, arrival, act});
        if (deadline_ == first) {
            feedback_->close(deadline_, channel_);
            deadline_ += plan_.timing.span;
        } else if (arrival == first) {
            if (feedback_->arrive(channel_.arrive(), arrival)) guard_.heard(wall_time(arrival));
        } else if (act == first) {
            feedback_->act();
        } else if (now == first) {
            return;
        } else if (scan == first) {
            take_scan();
        } else {
            hand_over();
        }
    }
}

void Presenter::take_scan() {
    const auto next = std::min_element(next_scan_.begin(), next_scan_.end());
    const auto i = static_cast<std::size_t>(next - next_scan_.begin());
    const PatchPlan& patch = felt_[i];
    const double force_n = object_.force_n(motor_.state().position_mm);
    const std::span<const double> forces_n = sensors_[i].feel(sensors_[i].arriving_n(force_n));
    if (radio_.in_use())
        radio_.take(patch.first_element, forces_n);
    else
        feedback_->sense({*next, patch.first_element, forces_n});
    *next += patch.scan_interval;
}

void Presenter::hand_over() {
    const TimePoint time = radio_.next_connection();
    if (const auto forces_n = radio_.connect()) feedback_->sense({time, 0, *forces_n});
}

// By the command of the step before.
void Presenter::move(TimePoint now) {
    if (now == now_) return;
    const Duration dt = now - now_;
    motor_.advance(command_, object_.force_n(motor_.state().position_mm), dt);
    object_.advance(motor_.state().position_mm, user_.lifted(intent_, seconds(now), seen_), dt);
    now_ = now;
}

void Presenter::see(double time_s, double force_n) {
    result_.peak_force_n = std::max(result_.peak_force_n, force_n);
    result_.held_force_n = force_n;
    if (!seen_.contact_s && force_n > 0) result_.contact_s = seen_.contact_s = time_s;
    if (!seen_.slip_s && object_.state().slips()) {
        result_.slip_onset_s = seen_.slip_s = time_s;
        highest_gain_ = *std::max_element(gains_.begin(), gains_.end());
    }
}

// Over the reaction time.
void Presenter::notice_weakness(double gain) {
    const double steps = intent_.reaction_s * plan_.scene.hand.emg_rate_hz;
    seen_.weakness += (1 - gain - seen_.weakness) / std::max(1.0, steps);
}

void Presenter::watch_telling(double time_s, const Estimate& estimate) {
    if (!seen_.contact_s) {
        untouched_.force_n = std::max(untouched_.force_n, estimate.force_n);
        untouched_.rate_hz = std::max(untouched_.rate_hz, estimate.rate_hz);
        return;
    }
    if (!result_.told_s && (estimate.force_n > untouched_.force_n || estimate.rate_hz > untouched_.rate_hz))
        result_.told_s = time_s - *seen_.contact_s;
}

void Presenter::watch_answer(double time_s, const ControllerStep& step) {
    if (!seen_.contact_s) {
        untouched_gain_ = step.gain;
        return;
    }
    if (!result_.answer_s && step.command < asked(step.effort, untouched_gain_) - answering_command)
        result_.answer_s = time_s - *seen_.contact_s;
}

void Presenter::watch_reaction(double time_s, const ControllerStep& step) {
    gains_[steps_++ % gains_.size()] = step.gain;
    const bool pulse = pulse_begins(step);
    if (!seen_.slip_s) {
        result_.false_pulses += pulse;
    } else if (!result_.slip_reaction_s && (pulse || step.gain > highest_gain_ + reaction_gain)) {
        result_.slip_reaction_s = time_s - *seen_.slip_s;
    }
}

bool Presenter::pulse_begins(const ControllerStep& step) {
    const bool pulsed =
        std::exchange(pulses_, step.command > asked(step.effort, step.gain) + pulsing_command);
    return pulses_ && !pulsed;
}

bool Presenter::is_over(double time_s) {
    // With recorded EMG there may be a contact until the recording ends.
    if (recorded_ && !seen_.contact_s) return time_s >= seconds(recorded_->table().times.back());
    return object_.state().broken || object_.state().slipped_mm > longest_slip_mm ||
           time_s >= user_.end_s(intent_, seen_);
}

void Presenter::conclude(double time_s) {
    result_.slipped_mm = object_.state().slipped_mm;
    const bool fell = !seen_.contact_s || object_.state().slipped_mm > longest_slip_mm;
    result_.outcome = object_.state().broken ? Outcome::broken : fell ? Outcome::dropped : Outcome::held;
    if (result_.outcome == Outcome::broken) result_.broken_s = time_s;
    if (result_.outcome == Outcome::dropped) result_.dropped_s = time_s;
}

}  // namespace afferent
