// Gives a decoder what it had: a hand's side, stepped through a recording.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "afferent/io/files/recording.hpp"
#include "afferent/nodes/hand_side.hpp"
#include "afferent/scene/scene.hpp"

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

// Steps, estimates and gains equal those of the recorded hand to the bit. Reads no more than a twentieth of a
// second ahead; memory does not grow with the recording.
class Replay {
  public:
    struct Output {
        // As packets are read.
        std::function<void(std::span<const Event>)> events = [](auto) {};
        std::function<void(const ControllerStep&)> step = [](const auto&) {};
        // The recorded hand began anew, at another place of the scene.
        std::function<void()> anew = [] {};
        // The grip is safe, for that reason.
        std::function<void(const std::string&)> safe = [](const auto&) {};
    };

    static Result<std::unique_ptr<Replay>> open(const std::filesystem::path& file, Output output);

    const Scene& scene() const noexcept { return scene_; }
    // What was recorded, and whether it was closed.
    proto::Recorded recorded() const noexcept { return reader_.head().recorded(); }
    bool closed() const noexcept { return reader_.closed(); }

    // The output begins with the first step at or after this time: the same steps as without. What is before
    // is read from two marks before, and not from the start. Before the first step.
    Result<void> begin_from(TimePoint time);

    // When the next step is due; nothing: there is none left.
    Result<std::optional<TimePoint>> next();
    // Does it. Only after next().
    void step();

    // Of the scene, what the last step has reached.
    TimePoint now() const noexcept { return now_; }
    ReplayCounts counts() const;
    // How much of the file has been read, 0 to 1.
    double fraction() const noexcept { return reader_.fraction(); }

  private:
    Replay(Scene scene, std::string file, RecordingReader reader, Output output);
    Result<void> make_side();
    Result<void> resume_at(const RecordedMark& mark);
    // Of all entries those that come before the step that is due.
    Result<void> take_what_is_due();
    bool comes_later() const;
    Result<void> take();
    Result<void> take_emg(const proto::EmgSamples& samples);
    Result<void> take_message(const proto::Envelope& message);
    Result<void> take_begin(const proto::Begin& begin);
    Result<void> take_mark(const proto::Mark& mark);
    void take_grip(const proto::Grip& grip);
    void give(const Reception& reception);
    TimePoint end_of_scene() const { return scene_start + scene_.duration(); }
    Error malformed(const std::string& what) const { return {Error::Kind::malformed, file_ + ": " + what}; }

    Scene scene_;
    std::string file_;
    RecordingReader reader_;
    Output output_;
    EmgTable emg_;
    std::unique_ptr<HandSide> side_;
    bool begun_ = false;  // the decoder, in this session
    std::optional<PacketReceiver> receiver_;
    std::unique_ptr<ClockedSource> profile_;  // knows the true force
    std::optional<double> true_force_n_;

    proto::Entry entry_;
    bool has_entry_ = false;  // which is still to be taken
    bool all_read_ = false;
    // Where the steps end, as far as the recording tells.
    std::optional<std::uint64_t> end_step_;
    std::optional<TimePoint> end_;
    TimePoint acted_until_ = scene_start;  // of all packets so far

    TimePoint from_ = scene_start;
    std::optional<TimePoint> correcting_mark_;
    TimePoint now_ = scene_start;
    ReplayCounts counts_;
};

}  // namespace afferent
