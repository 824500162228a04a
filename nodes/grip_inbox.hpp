// What a hand's link tells the loop that moves the hand: a bounded queue between two threads, which drops and
// counts what does not fit.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "afferent/io/wire/message_types.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/nodes/hand_end.hpp"
#include "afferent/nodes/hand_record.hpp"
#include "afferent/runtime/monotonic_time.hpp"
#include "afferent/runtime/slot_ring.hpp"

namespace afferent {

struct GripInput {
    enum class Kind { opened, begin, restart, reception, refused, ended, steer, acknowledged, stop };

    Kind kind = Kind::stop;
    MonotonicTime at{};                 // when it came
    TimePoint time;                     // begin: in the scene
    std::unique_ptr<HandEnd> link_end;  // begin: swapped for the hand's
    KeptReception reception;
    std::optional<Duration> ahead;  // steer: of the coprocessor's scene time
    PacketOffset offset;            // reception: after it
    proto::Envelope message;        // where it is recorded: the hello, the packet, the bye
    bool has_message = false;
};

// The span of packets that were dropped: the next packet that is not dropped reports it as a gap.
class LostSpan {
  public:
    void add(const Reception& dropped) {
        const TimePoint begin = dropped.gap ? dropped.gap->begin : dropped.known.begin;
        span_ = TimeSpan{span_ ? span_->begin : begin, dropped.known.end};
    }
    void tell(Reception& next) {
        if (span_) next.gap = TimeSpan{span_->begin, std::max(span_->end, next.known.begin)};
        span_.reset();
    }
    void forget() { span_.reset(); }

  private:
    std::optional<TimeSpan> span_;
};

// Packets that find no room are lost as if the link had lost them: the next one taken reports a gap. The
// beginning and the end of a session are never lost: they wait for room, and packets after them are dropped
// meanwhile.
class GripInbox {
  public:
    // With `keeps_messages` messages are passed on as well.
    GripInbox(std::size_t room, bool keeps_messages);

    // For the thread that runs the link. A session opens, begins at a place in its scene in one of two ways,
    // and ends.
    void opened(MonotonicTime now, const proto::Hello& hello);
    // The scene's `time` is `now`. `fresh` may be null: the hand has not begun yet.
    void begin(MonotonicTime now, TimePoint time, std::unique_ptr<HandEnd> fresh);
    void restart(MonotonicTime now);
    void ended(MonotonicTime now, const std::optional<proto::Bye>& bye);
    // For a packet, what it told and then the packet itself; for a refused one, the packet alone; for a gap,
    // the reception alone.
    void receive(const Reception& reception, const PacketOffset& offset, MonotonicTime now);
    void packet(const proto::Envelope& packet);
    void steer(MonotonicTime now, std::optional<Duration> ahead);
    void acknowledged(MonotonicTime now);
    void stop();
    // Passes on what waits, as far as there is room.
    void flush();
    // Packets that found no room.
    std::uint64_t dropped() const noexcept { return dropped_; }

    // For the loop.
    GripInput* next() noexcept { return ring_.next(); }
    void pop() noexcept { ring_.pop(); }

  private:
    GripInput* slot_for_packet();
    void pass_on(GripInput&& input);
    void finish_reception();

    SlotRing<GripInput> ring_;
    bool keeps_messages_;
    std::deque<GripInput> waiting_;  // never many
    GripInput* receiving_ = nullptr;
    bool dropping_ = false;  // the packet now being received is dropped
    LostSpan lost_;
    std::uint64_t dropped_ = 0;
};

}  // namespace afferent
