// A whole scene in one process and in virtual time: both sides, joined by the codec or by hand.
#pragma once

#include <functional>
#include <memory>

#include "afferent/io/links/channel.hpp"
#include "afferent/io/links/watchdog.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/nodes/coprocessor_side.hpp"
#include "afferent/nodes/hand_recording.hpp"
#include "afferent/nodes/hand_side.hpp"

namespace afferent {

// Which scans and packets travel between the sides, and when, is the same as for two processes in lockstep:
// so are events, estimates and gains.
class Run {
  public:
    struct Output {
        std::function<void(std::span<const Event>)> events = [](auto) {};
        std::function<void(const ControllerStep&)> step = [](const auto&) {};
        // Where the link carries packets: each as it closes.
        std::function<void(const proto::Envelope&)> packet = [](const auto&) {};
        // The samples that the coprocessor is given.
        std::function<void(const Scan&)> scan = [](const auto&) {};
    };

    // Opens the scene's tables. The scene outlives the run. `standard_input` as for CoprocessorSide.
    static Result<std::unique_ptr<Run>> open(const Scene& scene, Output output,
                                             TableSource::Read standard_input = {});

    // Writes down from here on what the hand receives and does. Before the first step, after its hello; it
    // outlives the run.
    void record(HandRecording& recording);
    // Closes that recording.
    Result<void> close_recording() { return recording_->close(now_, hand_ ? hand_->next_step() : 0); }

    // The time of what is due next; done() when that is the scene's end.
    TimePoint next();
    bool done() { return next() >= scene_start + scene_.duration(); }
    // Does what is due next. Throws SpikeStormError.
    Result<void> do_next();
    // Once, at the end: of the scene, or where it was broken off.
    void finish(TimePoint end);

    const CoprocessorSide& coprocessor() const noexcept { return *coprocessor_; }
    CoprocessorSide& coprocessor() noexcept { return *coprocessor_; }
    // Null where nothing of the scene needs an estimate.
    const HandSide* hand() const noexcept { return hand_.get(); }
    // The grip force behind the samples, where it is known.
    std::optional<double> true_force_n(TimePoint time) const;

    std::uint64_t packets() const noexcept;
    // On the link, with framing.
    std::uint64_t link_bytes() const noexcept { return link_bytes_; }
    const SampleSource* source() const noexcept;
    // Null where the scene has none.
    const Channel* channel() const noexcept { return channel_ ? &*channel_ : nullptr; }
    // What the hand's end of the link has seen; all zero where there are no packets.
    PacketCounts received() const noexcept { return receiver_ ? receiver_->counts() : PacketCounts{}; }
    std::uint64_t checksum_failures() const noexcept { return arrived_.checksum_failures; }
    // Why the hand went to its safe state; empty if it did not.
    std::string safe_reason() const { return watchdog_ ? watchdog_->reason() : std::string(); }

  private:
    Run(const Scene& scene, Output output);
    void carry(const proto::Envelope& packet);
    // The next arrival out of the channel, if nothing else comes before it.
    std::optional<Due> arrival();
    void arrive(TimePoint time);
    void rehearse();
    // Gives the hand what has come, and writes it down.
    void receive(TimePoint arrived);
    void follow_grip_state();
    // Into received_; returns the bytes that it took.
    std::size_t write_and_read(const proto::Envelope& packet);
    void step(ControllerStep step);

    const Scene& scene_;
    Output output_;
    std::unique_ptr<CoprocessorSide> coprocessor_;
    std::unique_ptr<HandSide> hand_;
    CoprocessorSide::Output coprocessor_output_;
    std::optional<PacketReceiver> receiver_;
    FrameWriter writer_;
    std::unique_ptr<FrameReader> reader_;
    proto::Envelope received_;
    std::optional<Channel> channel_;
    // On an imperfect channel the hand watches for silence, in virtual time.
    std::optional<Watchdog> watchdog_;
    HandRecording* recording_ = nullptr;
    FrameCounts arrived_;
    std::uint64_t carried_events_ = 0;
    TimePoint now_ = scene_start;
    std::uint64_t link_bytes_ = 0;
};

}  // namespace afferent
