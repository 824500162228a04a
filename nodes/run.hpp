// A whole scene in one process and in virtual time: both ends, joined by the packet codec or without it.
#pragma once

#include <functional>
#include <memory>

#include "afferent/io/links/channel.hpp"
#include "afferent/io/links/packet_intake.hpp"
#include "afferent/io/links/packet_order.hpp"
#include "afferent/io/wire/frame.hpp"
#include "afferent/nodes/coprocessor_end.hpp"
#include "afferent/nodes/given_tables.hpp"
#include "afferent/nodes/guarded_hand.hpp"
#include "afferent/nodes/hand_writer.hpp"
#include "afferent/nodes/observer.hpp"
#include "afferent/runtime/grip_guard.hpp"

namespace afferent {

// The same scans and packets travel between the ends, at the same times, as between two nodes in lockstep:
// events, estimates and gains are equal.
class Run {
  public:
    // Opens the scene's tables, but for those that are given. The scene outlives the run. `standard_input`
    // and `exchange` as for CoprocessorEnd.
    static Result<std::unique_ptr<Run>> open(const Plan& plan, Observer observer,
                                             TableSource::Read standard_input = {},
                                             EventExchange* exchange = nullptr, GivenTables given = {});

    // Records what the hand receives and does, in a session opened by this hello. To be called before
    // anything is done.
    Result<void> record(const std::filesystem::path& file, const proto::Hello& hello);
    // Completes the recording, if there is one. To be called after finish().
    Result<void> close();

    // The time of what is due next. At the scene's end nothing is: done().
    TimePoint next();
    bool done() { return next() >= plan_.end(); }
    // Does what is due next, `behind` after it was due by the clock. Throws SpikeStormError.
    Result<void> do_next(Duration behind = {});
    // To be called once, at the end of the scene or where it was broken off.
    void finish(TimePoint end);

    const Plan& plan() const noexcept { return plan_; }
    const CoprocessorEnd& coprocessor() const noexcept { return *coprocessor_; }
    CoprocessorEnd& coprocessor() noexcept { return *coprocessor_; }
    // Null where nothing in the scene needs an estimate.
    const HandEnd* hand() const noexcept { return hand_ ? &hand_->link_end() : nullptr; }
    // The grip force behind the samples, where it is known.
    std::optional<double> true_force_n(TimePoint time) const;

    std::uint64_t packets() const noexcept;
    // On the link, with framing.
    std::uint64_t link_bytes() const noexcept { return link_bytes_; }
    // What the hand has sent back to acknowledge packets, in frames of datagrams.
    std::uint64_t acknowledgement_bytes() const noexcept { return acknowledgement_bytes_; }
    const SampleSource* source() const noexcept;
    // What live events could not be passed on, and steps not written.
    OutputLosses lost_by_outputs() const noexcept {
        return {.steps = writer_.outputs().lost().steps, .events = live_.lost().events};
    }
    // Null where the scene has none.
    const Channel* channel() const noexcept { return channel_ ? &*channel_ : nullptr; }
    // What the hand's end of the link has counted; all zero where there are no packets.
    PacketCounts received() const noexcept;
    std::uint64_t checksum_failures() const noexcept { return arrived_.checksum_failures; }
    // Why the hand went to its safe state; empty if it did not.
    std::string safe_reason() const;

  private:
    Run(const Plan& plan, Observer observer);
    void carry(const proto::Envelope& packet);
    // The next arrival out of the channel, or the end of a packet's wait for those that it has overtaken, if
    // nothing else comes before it.
    std::optional<Due> arrival();
    void arrive(TimePoint time);
    // Tells the coprocessor what the hand has acknowledged by then.
    void take_acknowledgements(TimePoint until);
    void send_acknowledgement(TimePoint now);
    TimePoint wait_ends() const;
    // Whether anything takes what packets say.
    bool receives() const noexcept { return hand_ || !live_.empty(); }
    void receive_held(TimePoint now, MonotonicTime waited_until);
    void preallocate();
    // Gives the hand a packet.
    void receive(proto::Envelope& packet, TimePoint arrived, TimePoint now);
    void follow_grip_state();
    // Reads the packet back into received_; returns the bytes that it took on the link.
    std::size_t write_and_read(const proto::Envelope& packet);
    void step(const ControllerStep& step);

    const Plan& plan_;
    Observer observer_;
    std::unique_ptr<CoprocessorEnd> coprocessor_;
    ControllerStep step_;  // the last, with what is known of true forces
    HandRecords records_;
    HandWriter writer_;
    Outputs live_;
    std::optional<GuardedHand> hand_;
    std::optional<GripGuard> guard_;          // where there is a channel, which may be silent
    std::optional<HandRecording> recording_;  // of the packets, where there is no hand
    Observer coprocessor_observer_;
    std::optional<PacketIntake> intake_;  // where the link carries packets
    PacketOrder order_{Duration::zero()};
    FrameWriter frames_;
    std::unique_ptr<FrameReader> reader_;
    proto::Envelope received_;
    std::optional<Channel> channel_;
    // The other way, for what acknowledges packets: with the same faults, and without a channel at once.
    std::optional<Channel> way_back_;
    proto::Envelope answer_;
    bool answers_ = false;
    std::uint64_t acknowledgement_bytes_ = 0;
    FrameCounts arrived_;
    FrameCounts arrived_back_;
    std::uint64_t carried_events_ = 0;
    TimePoint now_ = scene_start;
    std::uint64_t link_bytes_ = 0;
};

}  // namespace afferent
