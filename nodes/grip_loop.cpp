#include "afferent/nodes/grip_loop.hpp"

#include <algorithm>
#include <utility>

namespace afferent {
namespace {

// Room for a burst of packets after a pause and for those that wait for delivery, and for the records of
// seconds of steps.
constexpr std::size_t room_for_packets = 128;
constexpr std::size_t room_for_records = 4096;
// Records are fewer where they have many parts: so many parts in all, some megabytes.
constexpr std::size_t room_for_parts = 1 << 18;

// The quantiles of the steps' lateness are computed every so many steps.
constexpr std::uint64_t steps_per_look = 256;

std::unique_ptr<HandEnd> with_room(std::unique_ptr<HandEnd> link_end) {
    link_end->make_room(room_for_packets);
    return link_end;
}

// A fraction of a second, and a few megabytes at most, whatever the patches' size.
std::size_t room_for_scans(const Plan& plan) {
    constexpr std::size_t most_forces = 1 << 20;
    return plan.samples_from == SamplesFrom::hand
               ? std::clamp<std::size_t>(most_forces / std::max<std::size_t>(1, plan.elements), 16, 512)
               : 1;
}

HandRecords records_for(const Plan& plan) {
    ControllerStep step = step_with_room(plan);
    const std::size_t parts = std::max<std::size_t>(1, step.parts.size() + step.readouts.size());
    return {std::clamp<std::size_t>(room_for_parts / parts, 64, room_for_records), std::move(step)};
}

GripGuard::Limits limits(const Plan& plan) {
    return {.freeze = plan.timing.freeze, .safe = plan.timing.safe, .rearm = plan.scene.hand.rearm};
}

}  // namespace

GripLoop::GripLoop(const Plan& plan, std::unique_ptr<HandEnd> link_end, Options options, MonotonicClock clock)
    : options_(std::move(options)),
      clock_(std::move(clock)),
      end_(plan.end()),
      records_(records_for(plan)),
      hand_(with_room(std::move(link_end)), records_,
            options_.lockstep ? GripState::operating : GripState::safe),
      guard_(limits(plan), clock_()),
      inbox_(room_for_packets, options_.keeps_messages),
      scans_(room_for_scans(plan), {scene_start, 0, std::vector<double>(plan.elements)}) {
    tell();
}

void GripLoop::take_inputs() {
    bool any = false;
    for (GripInput* input; (input = inbox_.next()); any = true) {
        take(*input);
        inbox_.pop();
    }
    if (any) tell();
}

void GripLoop::take(GripInput& input) {
    switch (input.kind) {
        case GripInput::Kind::opened:
            guard_.session_opened(input.at);
            ++told_.sessions;
            lost_.forget();
            return hand_.hello(input.message);
        case GripInput::Kind::begin:
            if (!options_.lockstep) pacer_.emplace(input.at, input.time);
            hand_.begin(input.time, input.link_end);
            told_.at = input.time;
            told_.begun = true;
            told_.at_end = false;
            return;
        case GripInput::Kind::restart:
            return hand_.restart(told_.at);
        case GripInput::Kind::reception:
            return receive(input);
        case GripInput::Kind::refused:
            return hand_.refused(input.message);
        case GripInput::Kind::ended:
            guard_.session_ended(input.at);
            if (input.has_message) hand_.bye(input.message);
            return hand_.session_ended();
        case GripInput::Kind::steer:
            if (pacer_) pacer_->steer(input.at, input.ahead);
            return;
        case GripInput::Kind::acknowledged:
            return guard_.acknowledged(input.at);
        case GripInput::Kind::stop:
            told_.stopped = true;
            return;
    }
}

void GripLoop::receive(GripInput& input) {
    // In lockstep no packet may be dropped: the end grows instead.
    if (!hand_.link_end().has_room() && !options_.lockstep) {
        ++told_.dropped_packets;
        return lost_.add(input.reception);
    }
    lost_.tell(input.reception);
    if (input.reception.stale)
        guard_.stale(input.at, input.reception.age);
    else if (input.reception.no_samples)
        guard_.without_samples(input.at);
    else if (input.reception.measured())
        guard_.heard(input.at);
    hand_.receive(std::move(input.reception), input.offset);
    if (input.has_message) hand_.packet(input.message);
}

bool GripLoop::do_next(MonotonicTime& wake) {
    wake = MonotonicTime::max();
    if (!told_.begun || told_.stopped || told_.at_end) return false;
    const Due due = hand_.link_end().next();
    if (due.time >= end_) {
        told_.at_end = true;
        tell();
        return true;
    }
    const MonotonicTime now = clock_();
    if (due.time > (options_.lockstep ? allowed_ : pacer_->scene_time(now))) {
        if (pacer_) wake = pacer_->wall(due.time);
        return false;
    }
    follow_guard(now);
    stepped_ = false;
    const bool done = hand_.link_end().do_next(
        [this, now](const ControllerStep& step) {
            options_.motor(step);
            if (options_.device)
                options_.device->command({step.command, now, pacer_->wall(step.known_until)});
            hand_.did(step);
            stepped_ = true;
        },
        [this](const Scan& scan) { feed(scan); });
    if (!done) {
        refused_by_.store(hand_.link_end().source(), std::memory_order_release);
        hand_.link_end().stop_scans();
    }
    // A packet is in time if it takes effect before the next step.
    if (pacer_ && due.kind != Kind::arrival) {
        const MonotonicTime after = clock_();
        pacer_->did(due.time, after);
        if (stepped_) {
            lateness_.add(pacer_->scene_time(after) - due.time);
            if (lateness_.count() % steps_per_look == 0) look_at_lateness();
        }
    }
    told_.at = due.time;
    tell();
    return true;
}

void GripLoop::follow_guard(MonotonicTime now) {
    // In lockstep time waits for the coprocessor.
    if (options_.lockstep) return;
    hand_.follow(guard_.state(now), guard_.cause());
}

void GripLoop::feed(const Scan& scan) {
    FeedScan* const slot = scans_.free_slot();
    if (!slot) {
        ++told_.dropped_scans;
        return;
    }
    slot->time = scan.time;
    slot->first = scan.first;
    slot->forces_n.assign(scan.forces_n.begin(), scan.forces_n.end());
    scans_.push();
    options_.fed();
}

std::optional<std::string> GripLoop::failure() const {
    const SampleSource* const source = refused_by_.load(std::memory_order_acquire);
    return source != nullptr ? std::optional(source->refusal().text) : std::nullopt;
}

void GripLoop::tell() {
    HandEnd& link_end = hand_.link_end();
    told_.next_step = link_end.next_step();
    told_.last_step = link_end.last_step();
    if (options_.lockstep) {
        const auto scan = link_end.source() ? link_end.source()->next() : std::nullopt;
        told_.next_scan = scan ? std::optional(scan->time) : std::nullopt;
    }
    told_.state = hand_.state();
    told_.cause = guard_.cause();
    told_.spent = guard_.spent();
    told_.freezes = hand_.freezes();
    told_.safe_states = hand_.safe_states();
    told_.late_packets = hand_.late_packets();
    told_.lost_steps = records_.lost_steps();
    told_.pacer = pacer_;
    if (told_.stopped || told_.at_end) look_at_lateness();
    report_.tell(told_);
}

void GripLoop::look_at_lateness() {
    told_.step_lateness = {lateness_.quantile(0.5), lateness_.quantile(0.99), lateness_.max()};
}

}  // namespace afferent
