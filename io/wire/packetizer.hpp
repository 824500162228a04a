// From events to packets: closes one at each deadline that has something to say.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/io/wire/code_sorter.hpp"
#include "afferent/io/wire/divisor.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/proto/aer.pb.h"

namespace afferent {

// What a packet of this layout takes at most, with its checksum.
std::size_t most_packet_bytes(const PacketLayout& layout);

// Packets cover scene time without holes: each spans [begin, end), in whole packet spans, and begins where
// the one before it ended. Silence is gathered until it ends or reaches the heartbeat, so that the receiver
// hears something at least that often. The packets depend on the events and the deadlines alone, not on how
// the calls are spread over time.
//
//     packetizer.push(events);                        // as they come, sorted
//     packetizer.close(deadline, [&](const proto::Envelope& packet) { link.send(packet); });
//     packetizer.finish(end, sink);                   // once, at the end of the scene
class Packetizer {
  public:
    // Throws ParameterError, as layout.check().
    explicit Packetizer(const PacketLayout& layout);

    // Begins in the middle of the scene: nothing before the last deadline at or before `time` is reported.
    // Before the first close.
    void begin_at(TimePoint time) noexcept {
        position_ = (time - scene_start) / layout_.span;
        if (position_ > 0) announce();
    }

    // Sorted, and not before events pushed earlier nor before the last deadline. They may lie beyond the next
    // deadline.
    void push(std::span<const Event> events) {
        pending_.insert(pending_.end(), events.begin(), events.end());
    }

    // Packets with all events before the deadline, a multiple of the packet's span; later events stay
    // pending. The packet that the sink is given is reused after it returns.
    template <class Sink>
    void close(TimePoint deadline, Sink&& sink) {
        assert((deadline - scene_start) % layout_.span == Duration::zero());
        advance((deadline - scene_start) / layout_.span, sink);
    }

    // What is left, through the first deadline at or after the end.
    template <class Sink>
    void finish(TimePoint end, Sink&& sink) {
        const std::int64_t position = (end - scene_start + layout_.span - Duration(1)) / layout_.span;
        advance(position, sink);
        if (silence_ > 0) sink(silent_packet());
    }

    // The next packets will tell in full where they begin and how many events were sent before: to be called
    // when a packet that the sink was given has been dropped, or when a new session goes on in the middle.
    void announce() noexcept {
        count_due_ = true;
        begins_due_ = announcements;
    }

    std::uint64_t packets() const noexcept { return packets_; }
    std::uint64_t events() const noexcept { return events_; }
    const PacketLayout& layout() const noexcept { return layout_; }

  private:
    template <class Sink>
    void advance(std::int64_t position, Sink&& sink) {
        while (position_ < position) {
            ++position_;
            ++silence_;
            const std::size_t events = due();
            if (events > 0) {
                collect_codes(events);
                for (std::uint32_t part = 0; !rest_.empty(); ++part) sink(next_part(part));
                silence_ = 0;
            } else if (silence_ == layout_.heartbeat_spans()) {
                sink(silent_packet());
            }
        }
    }

    std::size_t due() const noexcept;
    void collect_codes(std::size_t events);
    const proto::Envelope& next_part(std::uint32_t part);
    const proto::Envelope& silent_packet();
    void start_packet(std::uint32_t implied_spans);
    void tell_count(std::uint64_t modulus);

    // Several, so that a lossy link brings one.
    static constexpr std::uint32_t announcements = 8;

    PacketLayout layout_;
    PayloadCodec codec_;
    CodeSorter sorter_;
    Divisor tick_;
    std::vector<Event> pending_;
    std::size_t taken_ = 0;  // of the pending events, those that are in packets already
    std::vector<Code> codes_;
    std::span<const Code> rest_;  // codes that no part has taken yet
    std::int64_t position_ = 0;   // spans since the start of the scene that are closed
    std::uint32_t silence_ = 0;   // spans since the last packet
    // What the receiver has last been told of the running count, and where.
    std::int64_t told_at_ = 0;
    std::uint64_t told_events_ = 0;
    bool count_due_ = false;
    std::uint32_t begins_due_ = 0;
    std::uint64_t packets_ = 0;
    std::uint64_t events_ = 0;
    proto::Envelope packet_;
};

}  // namespace afferent
