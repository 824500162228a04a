#include "afferent/nodes/hand_recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace afferent {
namespace {

// A replay reads ahead up to an entry that shows that nothing else came before a step. Such an entry is
// written at least this often.
constexpr double signs_per_second = 20;
constexpr std::size_t emg_samples_per_entry = 4096;

std::int64_t since_start(TimePoint time) { return (time - scene_start).count(); }

std::uint64_t steps_per(double count_per_second, const Plan& plan) {
    const double steps = plan.scene.hand.emg_rate_hz / count_per_second;
    return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::llround(steps)));
}

}  // namespace

proto::GripState as_message(GripState state) {
    return state == GripState::safe     ? proto::SAFE
           : state == GripState::frozen ? proto::FROZEN
                                        : proto::OPERATING;
}

Result<HandRecording> HandRecording::create(const std::filesystem::path& file, const Plan& plan,
                                            proto::Recorded recorded, const HandEnd* link_end) {
    proto::RecordingHead head;
    head.set_scene(plan.scene.text());
    head.set_recorded(recorded);
    head.set_has_steps(link_end != nullptr);
    auto writer = RecordingWriter::create(file, std::move(head));
    if (!writer) return writer.error();
    HandRecording recording(plan, std::move(writer.value()), link_end != nullptr);
    if (link_end) {
        recording.write_emg(link_end->emg());
    } else {
        auto emg = EmgSource::open(plan.scene);
        if (!emg) return emg.error();
        recording.write_emg(emg.value().table());
    }
    return recording;
}

HandRecording::HandRecording(const Plan& plan, RecordingWriter writer, bool has_steps)
    : writer_(std::move(writer)),
      has_steps_(has_steps),
      records_true_force_(!plan.gripper && !states_grip(plan.scene.source)),
      steps_per_sign_(steps_per(signs_per_second, plan)),
      steps_per_mark_(steps_per(1, plan)) {
    if (plan.controller)
        for (const PartPlan& part : plan.controller->parts) shares_.push_back(part.decoded.share);
}

void HandRecording::hello(const proto::Hello& hello, std::uint64_t step) {
    *entry_.mutable_link()->mutable_hello() = hello;
    write_at(step);
}

void HandRecording::begin(TimePoint time, bool new_hand, std::uint64_t step) {
    entry_.mutable_begin()->set_time_ns(since_start(time));
    entry_.mutable_begin()->set_new_hand(new_hand);
    write_at(step);
}

void HandRecording::packet(const proto::Envelope& packet) {
    *entry_.mutable_link() = packet;
    write();
}

void HandRecording::packet(const HandRecord& record) {
    entry_.set_stale(record.stale);
    entry_.set_refused(record.refused);
    if (record.late) entry_.set_step(record.step);
    packet(record.message);
}

void HandRecording::bye(const proto::Bye& bye, std::optional<std::uint64_t> late_at) {
    *entry_.mutable_link()->mutable_bye() = bye;
    if (late_at) entry_.set_step(*late_at);
    write();
}

void HandRecording::grip_state(GripState state, const std::string& reason, std::uint64_t step) {
    entry_.mutable_grip()->set_state(as_message(state));
    entry_.mutable_grip()->set_reason(reason);
    write_at(step);
}

void HandRecording::step(const HandRecord& step) {
    const std::uint64_t next = step.step;
    const std::optional<double> true_force_n = step.done.true_force_n;
    if (records_true_force_ && true_force_n) {
        const bool changed = parts_changed(step.done);
        if (changed || true_force_n != true_force_n_) {
            true_force_n_ = true_force_n;
            proto::TrueForce& told = *entry_.mutable_true_force();
            told.set_force_n(*true_force_n_);
            told.mutable_part_n()->Assign(true_part_n_.begin(), true_part_n_.end());
            write_at(next - 1);
        }
    }
    if (next % steps_per_mark_ == 0) {
        write_mark(step);
        write_at(next);
    } else if (next % steps_per_sign_ == 0) {
        write_at(next);
    }
}

bool HandRecording::parts_changed(const ControllerStep& step) {
    bool by_shares = true;
    bool changed = false;
    for (std::size_t i = 0; i < step.parts.size(); ++i) {
        const double force_n = step.parts[i].true_force_n.value_or(0);
        by_shares = by_shares && force_n == shares_[i] * *step.true_force_n;
        changed = changed || i >= true_part_n_.size() || force_n != true_part_n_[i];
    }
    if (by_shares) return !std::exchange(true_part_n_, {}).empty();
    true_part_n_.clear();
    for (const PartForce& part : step.parts) true_part_n_.push_back(part.true_force_n.value_or(0));
    return changed;
}

void HandRecording::write_mark(const HandRecord& step) {
    const HandEnd::Memory& memory = step.memory;
    proto::Mark& mark = *entry_.mutable_mark();
    mark.set_time_ns(since_start(memory.time));
    mark.set_position(step.offset.spans);
    mark.set_counted_events(step.offset.counted_events);
    mark.set_heard_until_ns(since_start(memory.heard_until));
    mark.set_presumes_from_ns(since_start(memory.presumes_from));
    mark.set_force_n(memory.estimate.force_n);
    mark.set_sigma_n(memory.estimate.sigma_n);
    mark.set_rate_hz(memory.estimate.rate_hz);
    mark.set_doubt(static_cast<std::uint32_t>(memory.estimate.doubt));
    mark.set_first_step(memory.first_step);
    mark.set_command(memory.command);
    mark.set_gripper_mm(memory.gripper.position_mm);
    mark.set_gripper_mm_per_s(memory.gripper.speed_mm_per_s);
    if (step.done.true_force_n) mark.set_true_force_n(*step.done.true_force_n);
    mark.set_state(as_message(memory.state));
    mark.mutable_true_part_n()->Assign(true_part_n_.begin(), true_part_n_.end());
}

Result<void> HandRecording::close(TimePoint time, std::uint64_t step) {
    entry_.mutable_end()->set_time_ns(since_start(time));
    write_at(step);
    return writer_.close();
}

void HandRecording::write_emg(const EmgTable& emg) {
    TimePoint last = scene_start;
    for (std::size_t i = 0; i < emg.times.size(); ++i) {
        proto::EmgSamples& samples = *entry_.mutable_emg();
        samples.add_gap_ns((emg.times[i] - last).count());
        samples.add_counts(emg.counts[i]);
        if (emg.rest_counts) samples.set_rest_counts(*emg.rest_counts);
        last = emg.times[i];
        if (i + 1 == emg.times.size() || (i + 1) % emg_samples_per_entry == 0) write();
    }
}

void HandRecording::write_at(std::uint64_t step) {
    if (has_steps_) entry_.set_step(step);
    write();
}

void HandRecording::write() {
    writer_.write(entry_);
    entry_.Clear();
}

}  // namespace afferent
