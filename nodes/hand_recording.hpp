// Writes down what a hand received and did, so that a replay comes to the same.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "afferent/io/files/recording.hpp"
#include "afferent/nodes/hand_side.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Calls come in the order in which things happen. Steps are given as HandSide::next_step().
class HandRecording {
  public:
    // `side` is null where there is no hand, but only what is sent to one.
    static Result<HandRecording> create(const std::filesystem::path& file, const Scene& scene,
                                        proto::Recorded recorded, const HandSide* side);

    void hello(const proto::Hello& hello, std::uint64_t step = 0);
    // The decoder starts, with nothing known of before `time`; the hand too, if `anew`.
    void begin(TimePoint time, bool anew, std::uint64_t step = 0);
    // As it came, once it has been received: also what was refused. One that came too late to act at its
    // regular time acted before `late_at`.
    void packet(const proto::Envelope& packet, std::optional<std::uint64_t> late_at = std::nullopt,
                bool stale = false);
    void bye(const proto::Bye& bye, std::optional<std::uint64_t> late_at = std::nullopt);
    void grip_state(GripState state, const std::string& reason, std::uint64_t step);
    // After each. No receiver: no session.
    void step(const ControllerStep& step, const HandSide& side, const PacketReceiver* receiver);

    // Nothing follows: up to this step, or, without a hand, up to that time.
    Result<void> close(TimePoint time, std::uint64_t step = 0);

  private:
    HandRecording(const Scene& scene, RecordingWriter writer, bool has_steps);
    void write_emg(const EmgTable& emg);
    void write_mark(const HandSide::Memory& memory, const ControllerStep& step,
                    const PacketReceiver* receiver);
    void write_at(std::uint64_t step);
    void write();

    RecordingWriter writer_;
    bool has_steps_;
    bool true_force_from_table_;
    std::uint64_t steps_per_sign_;
    std::uint64_t steps_per_mark_;
    std::optional<double> true_force_n_;
    proto::Entry entry_;
};

}  // namespace afferent
