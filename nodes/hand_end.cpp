#include "afferent/nodes/hand_end.hpp"

#include <algorithm>
#include <cmath>

namespace afferent {

Result<std::unique_ptr<HandEnd>> HandEnd::open(const Plan& plan, std::optional<EmgTable> emg) {
    AFFERENT_TRY(source, emg ? Result<EmgSource>(EmgSource::of(plan.scene, std::move(*emg)))
                             : EmgSource::open(plan.scene));
    std::unique_ptr<HandEnd> link_end(new HandEnd(plan, std::move(source)));
    if (plan.gripper) {
        link_end->source_ = std::make_unique<ClockedSource>(plan);
    } else if (const scene::Table* const forces = force_table(plan.scene.source);
               forces && plan.samples_from == SamplesFrom::hand) {
        AFFERENT_TRY(table, TableSource::open(plan, *forces));
        link_end->source_ = std::move(table);
    }
    return link_end;
}

std::unique_ptr<HandEnd> HandEnd::replaying(const Plan& plan, EmgTable emg) {
    return std::unique_ptr<HandEnd>(new HandEnd(plan, EmgSource::of(plan.scene, std::move(emg))));
}

HandEnd::HandEnd(const Plan& plan, EmgSource emg)
    : plan_(plan), emg_(std::move(emg)), queue_(16), arrivals_(16) {
    if (plan.controller) {
        controller_.emplace(plan, emg_.closing_rest_counts());
        step_ = step_with_room(plan);
        queue_.schedule({scene_start, Kind::step, 0});
    }
    if (plan.gripper) gripper_.emplace(*plan.gripper);
    for (KeptReception& arrival : arrivals_) arrival.make_room(std::max<std::size_t>(256, plan.addresses));
}

void HandEnd::begin_at(TimePoint time) {
    now_ = time;
    if (!controller_) return;
    first_step_ = steps_ =
        static_cast<std::uint64_t>(std::ceil(seconds(time) * plan_.controller->emg_rate_hz));
    queue_.clear();
    queue_.schedule({next_step_time(), Kind::step, 0});
    each_controller([time](Controller& controller) { controller.restart(time); });
}

void HandEnd::tell_steps_of(const Plan& other) { other_.emplace(other, emg_.closing_rest_counts()); }

HandEnd::Memory HandEnd::memory() const {
    return {.time = step_.time,
            .first_step = first_step_,
            .next_step = steps_,
            .heard_until = controller_ ? controller_->heard_until() : scene_start,
            .presumes_from = controller_ ? controller_->presumes_from() : scene_start,
            .estimate = step_.estimate,
            .command = step_.command,
            .gripper = gripper_ ? gripper_->state() : Gripper::State{},
            .state = state()};
}

void HandEnd::resume(const Memory& memory) {
    first_step_ = memory.first_step;
    steps_ = memory.next_step;
    queue_.clear();
    queue_.schedule({next_step_time(), Kind::step, 0});
    controller_->resume_after(memory.time, memory.heard_until, memory.estimate, memory.presumes_from);
    // What the other controller had estimated is unknown.
    if (other_) other_->resume_after(memory.time, memory.heard_until, {}, memory.presumes_from);
    // The envelope's memory is long: it is run from its beginning, which costs little.
    for (std::uint64_t k = first_step_; k < steps_; ++k)
        each_controller([emg = emg_.sample(k)](Controller& controller) { controller.follow(emg); });
    now_ = memory.time;
    stepped_ = true;
    set_state(memory.state);
    correct(memory);
}

void HandEnd::correct(const Memory& memory) {
    step_.time = memory.time;
    step_.estimate = memory.estimate;
    step_.command = memory.command;
    controller_->correct(memory.estimate);
    if (gripper_) gripper_->resume(memory.gripper);
}

TimePoint HandEnd::next_step_time() const { return sample_time(steps_, plan_.scene.hand.emg_rate_hz); }

Due HandEnd::next() {
    const auto scan = source_ && scans_ ? source_->next() : std::nullopt;
    if (queue_.empty()) return scan.value_or(Due{TimePoint::max(), Kind::scan, 0});
    return scan ? std::min(*scan, queue_.next()) : queue_.next();
}

bool HandEnd::do_next(const OnStep& on_step, const OnScan& on_scan) {
    const Due due = next();
    now_ = due.time;
    if (due.kind == Kind::scan) {
        const std::optional<Scan> scan = source_->take(gripper_ ? gripper_->force_n() : 0);
        if (scan) on_scan(*scan);
        return scan.has_value();
    }
    queue_.pop();
    if (due.kind == Kind::arrival) {
        const Reception& arrival = arrivals_[first_arrival_];
        each_controller([&arrival](Controller& controller) { controller.receive(arrival); });
        first_arrival_ = (first_arrival_ + 1) % arrivals_.size();
        --waiting_;
        return true;
    }
    step();
    on_step(other_ ? other_step_ : step_);
    return true;
}

void HandEnd::step() {
    // Since the last step the hand has moved by its command.
    if (gripper_ && stepped_) gripper_->advance(step_.command, now_ - step_.time);
    stepped_ = true;
    const Emg emg = emg_.sample(steps_);
    step_ = controller_->step(now_, emg);
    tell_true_forces(step_);
    if (other_) {
        other_step_ = other_->step(now_, emg);
        tell_true_forces(other_step_);
    }
    ++steps_;
    queue_.schedule({next_step_time(), Kind::step, 0});
}

void HandEnd::tell_true_forces(ControllerStep& step) const {
    if (gripper_) {
        step.true_force_n = gripper_->force_n();
        tell_shares(plan_, step);
    } else if (source_) {
        step.true_force_n = source_->true_force_n(now_);
        source_->tell_true_forces(step);
    }
}

bool HandEnd::receive(const Reception& reception, TimePoint arrived) {
    const bool late = is_late(reception, arrived);
    next_arrival(reception, arrived).keep(reception);
    return late;
}

bool HandEnd::receive(KeptReception&& reception, TimePoint arrived) {
    const bool late = is_late(reception, arrived);
    std::swap(next_arrival(reception, arrived), reception);
    return late;
}

// A packet that acts at the time of a step is decoded before the step.
bool HandEnd::is_late(const Reception& reception, TimePoint arrived) const {
    const TimePoint acts = reception.known.end + plan_.timing.delivery;
    return acts < std::max(now_, arrived) || (stepped_ && acts <= step_.time);
}

KeptReception& HandEnd::next_arrival(const Reception& reception, TimePoint arrived) {
    if (!has_room()) make_room(2 * arrivals_.size());
    KeptReception& arrival = arrivals_[(first_arrival_ + waiting_++) % arrivals_.size()];
    const TimePoint acts = reception.known.end + plan_.timing.delivery;
    queue_.schedule({std::max({acts, now_, arrived}), Kind::arrival, 0});
    return arrival;
}

void HandEnd::make_room(std::size_t packets) {
    if (packets <= arrivals_.size()) return;
    // Rotates the oldest to the front, so that new ones follow the last.
    std::rotate(arrivals_.begin(), arrivals_.begin() + static_cast<std::ptrdiff_t>(first_arrival_),
                arrivals_.end());
    first_arrival_ = 0;
    arrivals_.resize(packets);
    queue_.reserve(packets + 1);
}

void HandEnd::restart(TimePoint now) {
    // The waiting packets belong to the session before.
    waiting_ = 0;
    queue_.remove(Kind::arrival);
    each_controller([now](Controller& controller) { controller.restart(now); });
}

}  // namespace afferent
