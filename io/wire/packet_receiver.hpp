// From packets to what a decoder needs: events, the spans that are known, and the gaps that are not.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/wire/divisor.hpp"
#include "afferent/io/wire/messages.hpp"
#include "afferent/io/wire/payload.hpp"

namespace afferent {

// Half-open: [begin, end).
struct TimeSpan {
    TimePoint begin;
    TimePoint end;

    friend bool operator==(const TimeSpan&, const TimeSpan&) = default;
};

// What one packet tells. The events stay valid until the next packet.
struct Reception {
    // Where nothing is known, and nothing will be: neither spikes nor silence. It may reach back into a span
    // of which a part was delivered and another lost.
    std::optional<TimeSpan> gap;
    // All spikes in it are known, these and no others, once `more` is false.
    TimeSpan known;
    // The time of an event is the begin of its tick. Sorted.
    std::span<const Event> events;
    // Further parts of this packet, with later events, are to come.
    bool more = false;
    // It was too old to be used: what it told is part of the gap.
    bool stale = false;
};

struct PacketCounts {
    std::uint64_t packets = 0;
    std::uint64_t events = 0;
    std::uint64_t gaps = 0;
    Duration unknown = Duration::zero();  // the gaps' length in all
    std::uint64_t lost_events = 0;  // as far as the sender has told; it does within a few packets after a gap
    std::uint64_t out_of_order = 0;
    std::uint64_t refused = 0;
    std::uint64_t late = 0;
    std::uint64_t stale = 0;  // too old to be used; their events are among the lost
};

// Follows one session from its first packet, at the start of the scene. The first packet to arrive later
// leaves a gap before it, as any other.
class PacketReceiver {
  public:
    // Throws ParameterError, as layout.check().
    explicit PacketReceiver(const PacketLayout& layout);

    // An error changes nothing but the counts: `out_of_order`, a packet from the past, which a datagram link
    // drops and on which a stream ends its session; or `malformed`.
    Result<Reception> receive(const proto::Envelope& packet);

    // What was received last is too old to be used: all that it told is a gap after all.
    Reception discard(const Reception& stale);

    // The session has ended, and this is what the sender said it sent: reports as a gap what is missing up to
    // `end`.
    std::optional<TimeSpan> finish(TimePoint end, std::uint64_t events_sent);

    // Goes on in the middle of a session: after the packet that ended there, in packet spans since the start
    // of the scene, and after so many events that were delivered or lost. Before the first packet.
    void resume(std::uint64_t position, std::uint64_t events_before);

    // When the packet acts is the application's business, and so is whether that was too late.
    void count_late() noexcept { ++counts_.late; }

    // Up to here, something is known or lost for good.
    TimePoint end() const noexcept { return time(position_); }
    // The same in packet spans since the start of the scene, for Status.
    std::uint64_t position() const noexcept { return static_cast<std::uint64_t>(position_); }

    // Delivered, or known to be lost, since the start of the session.
    std::uint64_t counted_events() const noexcept {
        return events_before_ + counts_.events + counts_.lost_events;
    }

    const PacketCounts& counts() const noexcept { return counts_; }

  private:
    // Where a packet stands in the session, in spans since the start of the scene.
    struct Place {
        std::int64_t begin = 0;
        std::int64_t end = 0;
        // Empty: nothing is missing.
        std::int64_t gap_begin = 0;
        std::int64_t gap_end = 0;
        // It is a further part of the packet before.
        bool continues = false;

        bool has_gap() const noexcept { return gap_begin < gap_end; }
    };

    // It tells of the same span as the parts before it, and no earlier code.
    struct NextPart {
        std::uint64_t number = 0;
        std::int64_t begin = 0;
        Code lowest = 0;
    };

    Result<Place> place(const proto::Envelope& packet) const;
    Result<std::int64_t> end_of(const proto::Envelope& packet, std::uint32_t spans) const;
    Result<std::uint64_t> newly_lost_events(const proto::Envelope& packet, bool has_gap) const;
    void set_events(std::int64_t position, std::span<const Code> codes);
    TimeSpan count_gap(std::int64_t begin, std::int64_t end);
    TimePoint time(std::int64_t position) const noexcept { return scene_start + position * layout_.span; }

    PacketLayout layout_;
    PayloadCodec codec_;
    Divisor addresses_;
    std::int64_t position_ = 0;
    // Of the packet that ends at position_: the part to come, if there is one.
    std::optional<NextPart> next_part_;
    std::int64_t gap_end_ = 0;  // of the last gap that was reported
    bool gap_since_count_ = false;
    std::uint64_t events_before_ = 0;
    std::vector<Event> events_;
    PacketCounts counts_;
};

}  // namespace afferent
