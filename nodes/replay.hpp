// Replays a recording: gives a hand's end what the recorded one received, with the same result.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "afferent/io/files/recording.hpp"
#include "afferent/nodes/hand_end.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/nodes/outputs.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

struct ReplayCounts {
    std::uint64_t sessions = 0;
    std::uint64_t packets = 0;
    std::uint64_t events = 0;
    std::uint64_t gaps = 0;
    std::uint64_t lost_events = 0;
    std::uint64_t late = 0;
    std::uint64_t out_of_order = 0;
    std::uint64_t refused = 0;
    std::uint64_t freezes = 0;
    std::uint64_t safe_states = 0;
};

// Steps, estimates and gains equal those of the recorded hand to the bit. No more than a twentieth of a
// second is read ahead, so that memory does not grow with the length of the recording.
class Replay {
  public:
    // With `decoder`, the steps are those of this decoder on the same packets. They are in open loop: the
    // hand moves as recorded, by the estimates of its own decoder. The outputs are those of the
    // scene `outputs`, and none without it: a recording by itself has no file written, and nothing sent.
    static Result<std::unique_ptr<Replay>> open(const std::filesystem::path& file, Observer observer,
                                                const std::optional<scene::Decoder>& decoder = {},
                                                const Scene* outputs = nullptr);
    // Completes the outputs, and returns their first error. To be called once, at the end.
    Result<void> close() { return outputs_.close(); }
    OutputLosses lost_by_outputs() const noexcept { return outputs_.lost(); }

    // The plan of the decoder whose steps are passed to the output.
    const Plan& plan() const noexcept { return other_plan_ ? *other_plan_ : plan_; }
    // What was recorded, and whether it was closed.
    proto::Recorded recorded() const noexcept { return reader_.head().recorded(); }
    bool closed() const noexcept { return reader_.closed(); }

    // Begins the output with the first step at or after this time; the steps are the same as in a replay from
    // the start. Reads no more of what lies before than the decoder's window needs. To be called before the
    // first step.
    Result<void> begin_from(TimePoint time);

    // When the next step is due; nothing if there is none left.
    Result<std::optional<TimePoint>> next();
    // Does the step that next() told of.
    void step();

    // The last step's time and estimate.
    TimePoint now() const noexcept { return now_; }
    const Estimate& last_estimate() const noexcept { return last_estimate_; }
    ReplayCounts counts() const;
    // How much of the file has been read, 0 to 1.
    double fraction() const noexcept { return reader_.fraction(); }

  private:
    Replay(Plan plan, std::optional<Plan> other_plan, std::string file, RecordingReader reader,
           Observer observer);
    Result<void> make_end();
    Result<void> resume_at(const RecordedMark& mark);
    // Takes the entries that come before the step that is due.
    Result<void> take_what_is_due();
    bool comes_later() const;
    Result<void> take();
    Result<void> take_emg(const proto::EmgSamples& samples);
    Result<void> take_message(const proto::Envelope& message);
    Result<void> take_begin(const proto::Begin& begin);
    Result<void> take_mark(const proto::Mark& mark);
    Result<void> take_true_parts(const google::protobuf::RepeatedField<double>& forces_n);
    void take_grip(const proto::Grip& grip);
    void give(const Reception& reception);
    TimePoint end_of_scene() const { return plan_.end(); }
    Error malformed(const std::string& what) const { return {Error::Kind::malformed, file_ + ": " + what}; }

    Plan plan_;
    std::optional<Plan> other_plan_;  // with another decoder
    std::string file_;
    RecordingReader reader_;
    Observer observer_;
    Outputs outputs_;
    EmgTable emg_;
    std::unique_ptr<HandEnd> link_end_;
    bool begun_ = false;  // the decoder has, in this session
    GripState state_ = GripState::operating;
    std::optional<PacketReceiver> receiver_;
    std::optional<double> true_force_n_;
    std::vector<double> true_part_n_;  // empty: they follow from the shares

    proto::Entry entry_;
    bool has_entry_ = false;  // entry_ is still to be taken
    bool all_read_ = false;
    // Where the steps end, as far as the recording tells.
    std::optional<std::uint64_t> end_step_;
    std::optional<TimePoint> end_;
    TimePoint acted_until_ = scene_start;  // when the last of the packets so far acts

    TimePoint from_ = scene_start;
    std::optional<TimePoint> correcting_mark_;
    TimePoint now_ = scene_start;
    Estimate last_estimate_{};
    ControllerStep told_step_{};
    ReplayCounts counts_;
};

}  // namespace afferent
