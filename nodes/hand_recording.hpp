// Records what a hand received and when it acted, so that a replay gives the same result.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "afferent/io/files/recording.hpp"
#include "afferent/nodes/hand_end.hpp"
#include "afferent/nodes/hand_record.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

proto::GripState as_message(GripState state);

// Calls are made in the order in which things happen. What happens between two steps is recorded with the
// number of the later one, HandEnd::next_step().
class HandRecording {
  public:
    // `end` is null where packets are recorded that are sent to a hand elsewhere: those have no steps.
    static Result<HandRecording> create(const std::filesystem::path& file, const Plan& plan,
                                        proto::Recorded recorded, const HandEnd* link_end);

    void hello(const proto::Hello& hello, std::uint64_t step = 0);
    // The decoder starts at `time` and knows nothing from before; so does the hand, if it is a new one.
    void begin(TimePoint time, bool new_hand, std::uint64_t step = 0);
    // The packet as it came, after it was received or refused.
    void packet(const proto::Envelope& packet);
    // The packet of a hand's record, with what became of it.
    void packet(const HandRecord& record);
    void bye(const proto::Bye& bye, std::optional<std::uint64_t> late_at = std::nullopt);
    void grip_state(GripState state, const std::string& reason, std::uint64_t step);
    // After each step.
    void step(const HandRecord& step);

    // Ends the recording: before this step, or, where there are no steps, at that time.
    Result<void> close(TimePoint time, std::uint64_t step = 0);

  private:
    HandRecording(const Plan& plan, RecordingWriter writer, bool has_steps);
    void write_emg(const EmgTable& emg);
    void write_mark(const HandRecord& step);
    // Keeps the parts' true forces, unless they follow from their shares; returns whether they have changed.
    bool parts_changed(const ControllerStep& step);
    void write_at(std::uint64_t step);
    void write();

    RecordingWriter writer_;
    bool has_steps_;
    bool records_true_force_;  // it can be computed otherwise
    std::uint64_t steps_per_sign_;
    std::uint64_t steps_per_mark_;
    std::optional<double> true_force_n_;
    std::vector<double> shares_;       // of the parts
    std::vector<double> true_part_n_;  // empty: they follow from the shares
    proto::Entry entry_;
};

}  // namespace afferent
