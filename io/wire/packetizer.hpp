// From events to packets: one at each deadline before which there were events, and regularly in silence.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "afferent/io/wire/divisor.hpp"
#include "afferent/io/wire/payload.hpp"
#include "afferent/io/wire/prediction_reference.hpp"
#include "afferent/io/wire/spike_predictor.hpp"
#include "afferent/proto/aer.pb.h"
#include "afferent/runtime/number_sorter.hpp"

namespace afferent {

// The size of the longest packet of this layout, with its checksum.
std::size_t most_packet_bytes(const PacketLayout& layout);

// Packets cover scene time without holes: each spans [begin, end), in whole packet spans, and begins where
// the one before it ended. A span of silence is reported when it ends or reaches the heartbeat, so that the
// receiver gets a packet at least that often. Where the layout gathers several spans in a packet, the
// beginning of a touch is not held back for that. Where spikes are predicted, a span that is as presumed
// counts as silence. The packets depend on the events and the deadlines alone, not on how the calls are
// spread over time.
//
//     packetizer.push(events);                        // as they come, sorted
//     packetizer.close(deadline, [&](const proto::Envelope& packet) { link.send(packet); });
//     packetizer.finish(end, sink);                   // once, at the end of the scene
class Packetizer {
  public:
    // Throws ParameterError, as layout.check().
    explicit Packetizer(const PacketLayout& layout);

    // Begins in the middle of the scene: nothing before the last deadline at or before `time` is reported. To
    // be called before the first close.
    void begin_at(TimePoint time) noexcept {
        position_ = (time - scene_start) / layout_.span;
        if (position_ > 0) announce();
        if (reference_) {
            reference_->begin(position_);
            follow_reference();
        }
    }

    // The events must be sorted, and neither before those pushed earlier nor before the last deadline. They
    // may be later than the next deadline.
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

    // Packets with all that is left, up to the first deadline at or after the end.
    template <class Sink>
    void finish(TimePoint end, Sink&& sink) {
        const std::int64_t position = (end - scene_start + layout_.span - Duration(1)) / layout_.span;
        ending_ = true;
        advance(position, sink);
        if (silence_ > 0) sink(silent_packet());
    }

    // The next packets will say in full where they begin and how many events were sent before. To be called
    // when a packet has been dropped after the sink was given it, or when a session begins in the middle of
    // the scene.
    void announce() noexcept {
        count_due_ = true;
        begins_due_ = announcements;
        restart_due_ = predictor_.has_value() && !reference_;
    }

    // What the other end has received, where the layout says that it acknowledges it: later packets refer to
    // that. False: it cannot be so, and changes nothing.
    bool acknowledge(const proto::Acknowledgement& acknowledgement);

    std::uint64_t packets() const noexcept { return packets_; }
    std::uint64_t events() const noexcept { return events_; }
    const PacketLayout& layout() const noexcept { return layout_; }
    // Null where spikes are not predicted.
    const SpikePredictor* predictor() const noexcept { return predictor_ ? &*predictor_ : nullptr; }

  private:
    template <class Sink>
    void advance(std::int64_t position, Sink&& sink) {
        while (position_ < position) {
            ++position_;
            ++silence_;
            const std::size_t events = due();
            if (events > gathered_) follow_touch();
            gathered_ = events;
            if (predictor_ ? foresee(events) : collect(events)) {
                for (std::uint32_t part = 0; part == 0 || !rest_.empty(); ++part) sink(next_part(part));
                silence_ = 0;
                gathered_ = 0;
                if (reference_) follow_reference();
            } else if ((predictor_ || events == 0) && silence_ == layout_.heartbeat_spans()) {
                sink(silent_packet());
                if (reference_) follow_reference();
            }
        }
    }

    // Whether a packet with events closes at position_.
    bool closes() const noexcept {
        return position_ % layout_.gathered_spans == 0 || position_ <= prompt_until_ ||
               silence_ == layout_.heartbeat_spans();
    }

    // There are events in the span that ends at position_.
    void follow_touch() noexcept {
        const std::int64_t heartbeat = layout_.heartbeat_spans();
        if (position_ - last_event_ > heartbeat) prompt_until_ = position_ + heartbeat;
        last_event_ = position_;
    }

    // How many pending events are before the end of the span.
    std::size_t due() const noexcept;
    void collect_codes(std::size_t events);
    // What is to be told when the span ends that does so at position_; false: nothing yet.
    bool collect(std::size_t events);
    bool foresee(std::size_t events);
    const proto::Envelope& next_part(std::uint32_t part);
    const proto::Envelope& silent_packet();
    // Every packet refers to the one before it, and nothing is lost on the way: it begins where that ended,
    // and a check of what is foreseen covers the count.
    bool in_order() const noexcept { return predictor_ && !reference_; }
    bool encode(std::span<const Code> codes, SpikePredictor::Manner manner);
    void follow_reference();
    void name_reference();
    void count_what_was_foreseen();
    void start_packet(std::uint32_t implied_spans);
    void imply_position();
    void tell_count(std::uint64_t modulus);
    void tell_check();

    // Several, so that at least one gets through a lossy link.
    static constexpr std::uint32_t announcements = 8;

    PacketLayout layout_;
    PayloadCodec codec_;
    std::optional<SpikePredictor> predictor_;  // of Encoding::predicted
    NumberSorter sorter_;
    Divisor tick_;
    std::vector<Event> pending_;
    std::size_t taken_ = 0;  // how many pending events are in packets already
    std::vector<Code> codes_;
    std::span<const Code> rest_;  // codes that are in no part yet
    std::int64_t position_ = 0;   // spans since the start of the scene that are closed
    std::uint32_t silence_ = 0;   // spans since the last packet
    std::size_t gathered_ = 0;    // events since the last packet
    // Where the span of the last event ended, and until where the beginning of a touch lasts.
    std::int64_t last_event_ = std::numeric_limits<std::int64_t>::min() / 2;
    std::int64_t prompt_until_ = std::numeric_limits<std::int64_t>::min();
    // The running count that was sent last, and at which position it, or a check, was.
    std::int64_t told_at_ = 0;
    std::uint64_t told_events_ = 0;
    bool count_due_ = false;
    // Where spikes are predicted: those told since the last packet, the payload of the next, whether
    // prediction is to start over, whether it does so with that packet, and the check that was sent last.
    std::uint64_t foreseen_ = 0;
    std::string surprises_;
    bool restart_due_ = false;
    bool restarts_ = false;
    bool ending_ = false;  // no span comes for which an event could wait
    std::uint32_t told_check_ = 0;
    // Where packets refer to what is acknowledged: that, which of it the predictor foresees from, which was
    // named last, whether the other end asks for another begin, and the predictor as it was before the span
    // that is encoded.
    std::optional<PredictionReference> reference_;
    std::int64_t told_from_ = 0;
    bool told_from_origin_ = true;
    std::int64_t named_ = 0;
    bool start_over_ = false;
    std::optional<SpikePredictor> before_;
    std::uint32_t begins_due_ = 0;
    std::uint64_t packets_ = 0;
    std::uint64_t events_ = 0;
    proto::Envelope packet_;
};

}  // namespace afferent
