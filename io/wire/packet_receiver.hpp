// From packets to what a decoder needs: events, the spans that are known, and the gaps that are not.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/wire/divisor.hpp"
#include "afferent/io/wire/messages.hpp"
#include "afferent/io/wire/packet_counts.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/io/wire/prediction_reference.hpp"
#include "afferent/io/wire/spike_predictor.hpp"

namespace afferent {

// What one packet says. The events stay valid until the next packet.
struct Reception {
    // A time of which nothing is known and nothing will be: neither spikes nor silence. It may begin in a
    // span that was delivered in part.
    std::optional<TimeSpan> gap;
    // A time of which all spikes are known: once `more` is false, these are all.
    TimeSpan known;
    // The time of an event is the begin of its tick. Sorted.
    std::span<const Event> events;
    // Where what comes as foreseen is not sent and no packet is lost: the sender foresees these events for
    // the heartbeat from known.end until then. Sorted. Nothing is presumed if the time is not after
    // known.end.
    TimePoint presumed_until = scene_start;
    std::span<const Event> presumed = {};
    // Further parts of this packet, with later events, are to come.
    bool more = false;
    // The packet cannot be used, and its time is part of the gap: it was too old when it came, or it tells
    // that the sensors are silent.
    bool stale = false;
    bool no_samples = false;
    // How old it was when it came, where that is judged; Duration::max(): not known yet.
    Duration age{};
    // How long it waited for a packet that it had overtaken, before it was received.
    Duration waited{};

    bool usable() const noexcept { return !stale && !no_samples; }
    // Otherwise it tells of a gap alone, as a bye does.
    bool measured() const noexcept { return known.begin < known.end; }
};

// A reception that outlives the next packet.
class KeptReception : public Reception {
  public:
    KeptReception() = default;
    KeptReception(KeptReception&&) noexcept = default;
    KeptReception& operator=(KeptReception&&) noexcept = default;

    // Allocates only where there are more events than there is room for.
    void keep(const Reception& told) {
        kept_.assign(told.events.begin(), told.events.end());
        kept_presumed_.assign(told.presumed.begin(), told.presumed.end());
        static_cast<Reception&>(*this) = told;
        events = kept_;
        presumed = kept_presumed_;
    }
    void make_room(std::size_t count) {
        kept_.reserve(count);
        kept_presumed_.reserve(count);
    }
    std::span<Event> kept_events() noexcept { return kept_; }

  private:
    std::vector<Event> kept_, kept_presumed_;
};

// How many spans a packet covers.
std::uint32_t spans_of(const proto::Envelope& packet, const PacketLayout& layout);

// Follows one session from the start of the scene. If the first packet to arrive begins later, there is a gap
// before it.
class PacketReceiver {
  public:
    // Throws ParameterError, as layout.check().
    explicit PacketReceiver(const PacketLayout& layout);

    // An error changes nothing but the counts. `out_of_order`: the packet came late or twice; on a datagram
    // link it is dropped, on a stream it ends the session. Otherwise `malformed`; so is a packet that ends
    // after `latest`. Where spikes are predicted, those that follow a gap or a malformed one tell of a gap
    // alone, until what is foreseen begins anew: what they say refers to what has not come. Where packets are
    // acknowledged, they do so after a malformed one only.
    Result<Reception> receive(const proto::Envelope& packet, TimePoint latest = TimePoint::max());

    // Where a packet stands among those of its session; nothing where receive() would refuse it for that.
    struct Standing {
        std::int64_t end = 0;  // in packet spans since the start of the scene
        std::uint32_t part = 0;
        // What was sent just before it has not been received: it will be a gap, unless it comes first.
        bool misses_some = false;
    };
    std::optional<Standing> standing(const proto::Envelope& packet) const;

    // Something that could not be read has come in place of a packet. Where spikes are predicted and every
    // packet refers to the one before, packets then tell of gaps alone until the sender starts over.
    void lose_frame() noexcept;

    // The packet that was received last is not usable(): its time becomes a gap.
    Reception discard(const Reception& unusable);

    // The session has ended, and the sender says how many events it has sent. Returns what is missing before
    // `end` as a gap.
    std::optional<TimeSpan> finish(TimePoint end, std::uint64_t events_sent);

    // Continues in the middle of a session: at this position, in packet spans since the start of the scene,
    // with this number of events delivered or lost before it. To be called before the first packet. Where
    // spikes are predicted, packets then tell of gaps alone until the sender starts over.
    void resume(std::uint64_t position, std::uint64_t events_before);

    // Where the layout says that packets are acknowledged: makes the message an acknowledgement that is to be
    // sent now. Returns false, and leaves the message as it is, if none is due.
    bool acknowledge(proto::Envelope& message);

    // Before this time everything is known or lost for good.
    TimePoint end() const noexcept { return time(position_); }
    // The same in packet spans since the start of the scene.
    std::uint64_t position() const noexcept { return static_cast<std::uint64_t>(position_); }

    // Events delivered or known to be lost since the start of the session.
    std::uint64_t counted_events() const noexcept {
        return events_before_ + counts_.events + counts_.lost_events;
    }

    const PacketCounts& counts() const noexcept { return counts_; }

  private:
    // Where a packet stands in the session, in spans since the start of the scene.
    struct Span {
        std::int64_t begin = 0;
        std::int64_t end = 0;
        // An empty gap: nothing is missing.
        std::int64_t gap_begin = 0;
        std::int64_t gap_end = 0;
        // It holds a further part of the previous packet.
        bool continues = false;

        bool has_gap() const noexcept { return gap_begin < gap_end; }
    };

    // The next part of a packet is of the same span, and begins with no lower code.
    struct NextPart {
        std::uint64_t number = 0;
        std::int64_t begin = 0;
        Code lowest = 0;
    };

    Result<Span> span_of(const proto::Envelope& packet) const;
    bool may_imply_position(const proto::Envelope& packet) const noexcept;
    Result<std::int64_t> end_of(const proto::Envelope& packet, std::uint32_t spans) const;
    Result<std::uint64_t> newly_lost_events(const proto::Envelope& packet, bool has_gap) const;
    // The first span of the packet that may hold events.
    std::int64_t first_with_events(std::int64_t begin, std::int64_t end) const noexcept {
        return std::max(begin, end - layout_.gathered_spans);
    }
    bool refers_to_lost(const proto::Envelope& packet, const Span& span) const noexcept;
    Reception only_gap(const proto::Envelope& packet, const Span& span, std::uint64_t lost);
    // The codes of the packet's last span with events; all before that are in events_.
    Result<std::span<const Code>> read_codes(const proto::Envelope& packet, const Span& span);
    Result<std::span<const Code>> foresee(const proto::Envelope& packet, const Span& span);
    Result<std::span<const Code>> foresee_from_reference(const proto::Envelope& packet, const Span& span);
    Result<std::span<const Code>> told_from_reference(const proto::Envelope& packet, const Span& span);
    Result<std::span<const Code>> foresee_spans(const proto::Envelope& packet,
                                                std::span<const std::byte> payload, const Span& span,
                                                bool exactly);
    Result<void> find_reference(const ReferenceName& name, const Span& span);
    void add_events(std::int64_t first, std::span<const Code> codes) { append(events_, first, codes); }
    void append(std::vector<Event>& events, std::int64_t first, std::span<const Code> codes) const;
    void presume(Reception& reception);
    TimeSpan count_gap(std::int64_t begin, std::int64_t end);
    TimePoint time(std::int64_t position) const noexcept { return scene_start + position * layout_.span; }

    PacketLayout layout_;
    PayloadCodec codec_;
    std::optional<SpikePredictor> predictor_;  // of Encoding::predicted
    bool foresees_ = true;                     // as the sender does
    std::optional<SpikePredictor> ahead_;      // where spikes are presumed: after the last packet
    // Where packets refer to what is acknowledged: that, and whether something is to be acknowledged.
    std::optional<PredictionReference> reference_;
    bool acknowledge_due_ = false;
    bool has_all_parts_ = true;  // of the last packet, so far
    Divisor addresses_;
    std::int64_t position_ = 0;
    // The part that is missing from the packet that ends at position_, if one is.
    std::optional<NextPart> next_part_;
    std::int64_t gap_end_ = 0;  // where the last reported gap ends
    bool gap_since_count_ = false;
    std::uint64_t events_before_ = 0;
    std::vector<Event> events_;
    std::vector<Event> presumed_;
    PacketCounts counts_;
};

}  // namespace afferent
