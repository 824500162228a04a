#include "afferent/nodes/hand_side.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/scene/force_rate.hpp"
#include "afferent/scene/parameters.hpp"

namespace afferent {
namespace {

// The command of a hand whose safe state is to open.
constexpr double opening_command = -0.5;

}  // namespace

Result<std::unique_ptr<HandSide>> HandSide::open(const Scene& scene) {
    Result<EmgSource> emg = EmgSource::open(scene);
    if (!emg) return emg.error();
    std::unique_ptr<HandSide> side(new HandSide(scene, std::move(emg.value())));
    if (simulated_hand(scene)) {
        side->gripper_.emplace(gripper_parameters(scene.description().hand()));
        side->source_ = std::make_unique<ClockedSource>(scene);
    } else if (scene.description().source().has_link()) {
        auto table = TableSource::open(scene, scene.description().source().link().table());
        if (!table) return table.error();
        side->source_ = std::move(table.value());
    }
    return side;
}

std::unique_ptr<HandSide> HandSide::replaying(const Scene& scene, EmgTable emg) {
    std::unique_ptr<HandSide> side(new HandSide(scene, EmgSource::of(scene, std::move(emg))));
    if (simulated_hand(scene)) side->gripper_.emplace(gripper_parameters(scene.description().hand()));
    return side;
}

HandSide::HandSide(const Scene& scene, EmgSource emg)
    : scene_(scene),
      timing_(link_timing(scene.description().link())),
      emg_(std::move(emg)),
      rate_(read_addresses(scene), from_milliseconds(scene.description().decoder().window_ms())),
      estimator_(make_estimator(scene)),
      gain_(gain_parameters(scene.description().gain())),
      queue_(16),
      arrivals_(16) {
    queue_.schedule({scene_start, Kind::step, 0});
    for (Arrival& arrival : arrivals_) arrival.events.reserve(std::max<std::size_t>(256, scene.addresses()));
}

void HandSide::begin_at(TimePoint time) {
    const double rate_hz = scene_.description().hand().emg_rate_hz();
    first_step_ = steps_ = static_cast<std::uint64_t>(std::ceil(seconds(time) * rate_hz));
    queue_ = EventQueue(16);
    queue_.schedule({next_step_time(), Kind::step, 0});
    rate_.reset(time);
    now_ = time;
}

HandSide::Memory HandSide::memory() const {
    return {.time = step_.time,
            .first_step = first_step_,
            .next_step = steps_,
            .heard_until = rate_.heard_until(),
            .estimate = step_.estimate,
            .command = step_.command,
            .gripper = gripper_ ? gripper_->state() : Gripper::State{},
            .state = state_};
}

void HandSide::resume(const Memory& memory) {
    first_step_ = memory.first_step;
    steps_ = memory.next_step;
    queue_ = EventQueue(16);
    queue_.schedule({next_step_time(), Kind::step, 0});
    rate_.resume(memory.time, memory.heard_until);
    // The envelope's memory is long: it is run from its beginning, which costs little.
    for (std::uint64_t k = first_step_; k < steps_; ++k) (void)emg_.sample(k);
    now_ = memory.time;
    stepped_ = true;
    state_ = memory.state;
    correct(memory);
}

void HandSide::correct(const Memory& memory) {
    step_.time = memory.time;
    step_.estimate = memory.estimate;
    step_.command = memory.command;
    estimator_.resume(memory.estimate);
    if (gripper_) gripper_->resume(memory.gripper);
}

TimePoint HandSide::next_step_time() const {
    return sample_time(steps_, scene_.description().hand().emg_rate_hz());
}

Due HandSide::next() {
    if (source_)
        if (const auto scan = source_->next(); scan && *scan < queue_.next()) return *scan;
    return queue_.next();
}

Result<void> HandSide::do_next(const OnStep& on_step, const OnScan& on_scan) {
    const Due due = next();
    now_ = due.time;
    if (due.kind == Kind::scan) {
        const Result<Scan> scan = source_->take(gripper_ ? gripper_->force_n() : 0);
        if (!scan) return scan.error();
        on_scan(scan.value());
        return success();
    }
    queue_.pop();
    if (due.kind == Kind::arrival) {
        const Arrival& arrival = arrivals_[first_arrival_];
        if (const auto& gap = arrival.reception.gap) rate_.lose(gap->begin, gap->end);
        rate_.observe(arrival.reception.known.begin, arrival.reception.known.end, arrival.events);
        first_arrival_ = (first_arrival_ + 1) % arrivals_.size();
        --waiting_;
        return success();
    }
    step();
    on_step(step_);
    return success();
}

// The deadline of the last packet that would have been delivered by now if there had been events to send.
TimePoint HandSide::last_delivery(TimePoint now) const noexcept {
    const Duration since = now - timing_.delivery - scene_start;
    return scene_start + std::max(since, 0ns) / timing_.packet * timing_.packet;
}

void HandSide::step() {
    // Until now the hand has moved by the last command.
    if (gripper_ && stepped_) gripper_->advance(step_.command, now_ - step_.time);
    stepped_ = true;

    rate_.presume_silence(std::min(last_delivery(now_), rate_.heard_until() + timing_.heartbeat));
    rate_.advance(now_);
    step_.time = now_;
    step_.estimate = estimator_(rate_);
    step_.effort = emg_.sample(steps_);
    step_.closing_counts = emg_.closing_counts();
    step_.gain = state_ == GripState::operating ? gain_(step_.estimate.force_n) : 0;
    step_.command = std::clamp(step_.gain * step_.effort.closing - step_.effort.opening, -1.0, 1.0);
    if (state_ == GripState::safe && scene_.description().hand().safe_state() == proto::OPEN)
        step_.command = opening_command;
    if (gripper_)
        step_.true_force_n = gripper_->force_n();
    else if (source_)
        step_.true_force_n = source_->true_force_n(now_);
    ++steps_;
    queue_.schedule({next_step_time(), Kind::step, 0});
}

bool HandSide::receive(const Reception& reception, TimePoint arrived) {
    const TimePoint acts = reception.known.end + timing_.delivery;
    const TimePoint now = std::max(now_, arrived);
    // A packet that acts at the time of a step is decoded before it.
    const bool late = acts < now || (stepped_ && acts <= step_.time);
    if (waiting_ == arrivals_.size()) {
        // More packets wait than ever before: make room, with the oldest first.
        std::rotate(arrivals_.begin(), arrivals_.begin() + static_cast<std::ptrdiff_t>(first_arrival_),
                    arrivals_.end());
        first_arrival_ = 0;
        arrivals_.resize(2 * arrivals_.size());
    }
    Arrival& arrival = arrivals_[(first_arrival_ + waiting_++) % arrivals_.size()];
    arrival.reception = reception;
    arrival.events.assign(reception.events.begin(), reception.events.end());
    arrival.reception.events = {};
    queue_.schedule({std::max(acts, now), Kind::arrival, 0});
    return late;
}

void HandSide::restart(TimePoint now) {
    // The packets that wait belong to the session before.
    waiting_ = 0;
    EventQueue kept(16);
    while (!queue_.empty())
        if (const Due due = queue_.pop(); due.kind != Kind::arrival) kept.schedule(due);
    queue_ = std::move(kept);
    rate_.reset(now);
    estimator_.reset();
    state_ = GripState::operating;
}

}  // namespace afferent
