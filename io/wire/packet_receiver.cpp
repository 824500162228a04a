#include "afferent/io/wire/packet_receiver.hpp"

#include <algorithm>

#include "afferent/proto/aer.pb.h"

namespace afferent {
namespace {

Error malformed(const std::string& text) { return {Error::Kind::malformed, "packet: " + text}; }

// 146 years: longer than any scene, and far from an overflow.
std::uint64_t longest_position(const PacketLayout& layout) {
    return static_cast<std::uint64_t>((std::int64_t{1} << 62) / layout.span.count());
}

}  // namespace

std::uint32_t spans_of(const proto::Envelope& packet, const PacketLayout& layout) {
    if (packet.spans() != 0) return packet.spans();
    return packet.payload().empty() ? layout.heartbeat_spans() : layout.gathered_spans;
}

PacketReceiver::PacketReceiver(const PacketLayout& layout)
    : layout_(layout), codec_(layout), addresses_(layout.addresses) {
    events_.reserve(layout_.max_events);
    if (layout_.encoding != Encoding::predicted) return;
    predictor_.emplace(layout_);
    if (layout_.acknowledged) {
        reference_.emplace(layout_);
    } else if (layout_.tolerance > 0ns) {
        ahead_.emplace(layout_);
        presumed_.reserve(std::max<std::size_t>(256, layout_.addresses));
    }
}

Result<Reception> PacketReceiver::receive(const proto::Envelope& packet, TimePoint latest) {
    const auto refuse = [this](const Error& error) {
        if (error.kind == Error::Kind::out_of_order) {
            ++counts_.out_of_order;
        } else {
            ++counts_.refused;
            lose_frame();
        }
        return error;
    };
    const Result<Span> found_span = span_of(packet);
    if (!found_span) return refuse(found_span.error());
    const Span& span = found_span.value();
    if (time(span.end) > latest)
        return refuse(malformed("is stamped " + std::to_string((time(span.end) - latest) / 1ms) +
                                " ms later than can be"));
    const Result<std::uint64_t> lost = newly_lost_events(packet, span.has_gap());
    if (!lost) return refuse(lost.error());
    const std::string& payload = packet.payload();
    if (payload.empty() && (packet.part() > 0 || packet.more())) return refuse(malformed("a part is empty"));
    if (refers_to_lost(packet, span)) return only_gap(packet, span, lost.value());
    events_.clear();
    const Result<std::span<const Code>> codes = read_codes(packet, span);
    if (!codes) return refuse(codes.error());
    if (span.continues && codes.value().front() < next_part_->lowest)
        return refuse(malformed("has a part with events before those of the last"));

    Reception reception;
    if (span.has_gap()) reception.gap = count_gap(span.gap_begin, span.gap_end);
    position_ = span.end;
    next_part_.reset();
    if (packet.more())
        next_part_ = NextPart{std::uint64_t{packet.part()} + 1, span.begin,
                              codes.value().empty() ? 0 : codes.value().back()};
    counts_.lost_events += lost.value();
    if (packet.has_count()) gap_since_count_ = false;
    ++counts_.packets;
    add_events(first_with_events(span.begin, span.end), codes.value());
    counts_.events += events_.size();
    reception.known = {time(span.begin), time(span.end)};
    reception.events = events_;
    reception.more = packet.more();
    reception.no_samples = packet.has_no_samples_since_ns();
    reception.presumed_until = reception.known.end;
    if (ahead_ && !packet.more()) presume(reception);
    return reception;
}

// The sender codes its next packet with the same predictor. If it leaves these spans out, they came as this
// says.
void PacketReceiver::presume(Reception& reception) {
    ahead_->foresee_as(*predictor_);
    presumed_.clear();
    const std::int64_t end = position_ + layout_.heartbeat_spans();
    for (std::int64_t at = position_; at < end; ++at) append(presumed_, at, ahead_->presume());
    reception.presumed_until = time(end);
    reception.presumed = presumed_;
}

std::optional<PacketReceiver::Standing> PacketReceiver::standing(const proto::Envelope& packet) const {
    const Result<Span> found_span = span_of(packet);
    if (!found_span) return std::nullopt;
    return Standing{found_span.value().end, packet.part(), found_span.value().has_gap()};
}

Reception PacketReceiver::discard(const Reception& unusable) {
    const auto position = [&](TimePoint time) { return (time - scene_start) / layout_.span; };
    const TimeSpan gap = count_gap(position(unusable.known.begin), position(unusable.known.end));
    if (unusable.stale) ++counts_.stale;
    counts_.events -= unusable.events.size();
    counts_.lost_events += unusable.events.size();
    Reception discarded = unusable;
    discarded.gap = TimeSpan{unusable.gap ? unusable.gap->begin : gap.begin, gap.end};
    discarded.known = {gap.end, gap.end};
    discarded.events = discarded.presumed = {};
    discarded.presumed_until = gap.end;
    return discarded;
}

std::optional<TimeSpan> PacketReceiver::finish(TimePoint end, std::uint64_t events_sent) {
    const std::int64_t last = (end - scene_start + layout_.span - Duration(1)) / layout_.span;
    const std::int64_t begin =
        std::max(gap_end_, next_part_ ? first_with_events(next_part_->begin, position_) : position_);
    const std::uint64_t delivered = events_before_ + counts_.events;
    counts_.lost_events = std::max(counts_.lost_events, events_sent - std::min(events_sent, delivered));
    if (begin >= last) return std::nullopt;
    position_ = last;
    next_part_.reset();
    return count_gap(begin, last);
}

void PacketReceiver::resume(std::uint64_t position, std::uint64_t events_before) {
    position_ = gap_end_ = static_cast<std::int64_t>(std::min(position, longest_position(layout_)));
    events_before_ = events_before;
    // It is no longer known whether the last count was sent before a gap or after it.
    gap_since_count_ = true;
    foresees_ = position == 0;
}

void PacketReceiver::lose_frame() noexcept {
    if (!reference_) foresees_ = false;
}

bool PacketReceiver::refers_to_lost(const proto::Envelope& packet, const Span& span) const noexcept {
    if (!predictor_) return false;
    if (packet.part() > 0 && !span.continues) return true;
    if (reference_) {
        if (foresees_) return false;
        std::span<const std::byte> payload = std::as_bytes(std::span(packet.payload()));
        return packet.part() > 0 || !take_name(payload).value_or(ReferenceName()).is_origin;
    }
    const bool begins_nowhere = packet.position() == 0 && counts_.packets == 0;
    return !packet.restart() && (!foresees_ || span.has_gap() || begins_nowhere);
}

Reception PacketReceiver::only_gap(const proto::Envelope& packet, const Span& span, std::uint64_t lost) {
    Reception reception;
    const std::int64_t begin = span.has_gap() ? span.gap_begin : std::max(span.begin, gap_end_);
    if (begin < span.end) reception.gap = count_gap(begin, span.end);
    reception.known = {time(span.end), time(span.end)};
    reception.more = packet.more();
    position_ = span.end;
    next_part_.reset();
    if (packet.more()) next_part_ = NextPart{std::uint64_t{packet.part()} + 1, span.begin, 0};
    if (reference_ && foresees_) {
        reference_->record_lost(span.end);
        has_all_parts_ = false;
    } else {
        foresees_ = false;
        acknowledge_due_ = true;
    }
    counts_.lost_events += lost;
    if (packet.has_count()) gap_since_count_ = false;
    ++counts_.packets;
    return reception;
}

Result<std::span<const Code>> PacketReceiver::read_codes(const proto::Envelope& packet, const Span& span) {
    if (reference_) return foresee_from_reference(packet, span);
    if (predictor_) {
        Result<std::span<const Code>> codes = foresee(packet, span);
        foresees_ = codes.has_value();
        return codes;
    }
    return codec_.decode(std::as_bytes(std::span(packet.payload())),
                         layout_.spans_with_events(spans_of(packet, layout_)));
}

Result<std::span<const Code>> PacketReceiver::foresee_from_reference(const proto::Envelope& packet,
                                                                     const Span& span) {
    // Unless all goes well, that is to be told.
    acknowledge_due_ = true;
    // The packet tells of silence, but names no reference from which the receiver could go on.
    if (!foresees_ && packet.payload().empty()) return std::span<const Code>();
    Result<std::span<const Code>> codes = told_from_reference(packet, span);
    // If the sender has left the reference in one place for too long, it has to begin anew.
    foresees_ = codes.has_value() && reference_->fill() <= 1;
    if (!foresees_) return codes;
    has_all_parts_ = packet.part() == 0 || (has_all_parts_ && !span.has_gap());
    reference_->set_last_known(has_all_parts_ && !packet.more());
    // In silence, too, so that the sender can forget what is before it.
    acknowledge_due_ = !codes.value().empty() || !events_.empty() || reference_->fill() > 0.25;
    return codes;
}

Result<std::span<const Code>> PacketReceiver::told_from_reference(const proto::Envelope& packet,
                                                                  const Span& span) {
    std::span<const std::byte> payload = std::as_bytes(std::span(packet.payload()));
    if (packet.part() > 0) {
        AFFERENT_TRY(codes, codec_.decode(payload));
        predictor_->add(codes);
        reference_->record_more(predictor_->told());
        return codes;
    }
    reference_->record_lost(span.begin);
    if (payload.empty()) {
        for (std::int64_t at = span.begin; at < span.end; ++at) reference_->record({});
        return std::span<const Code>();
    }
    const auto name = take_name(payload);
    if (!name) return malformed("does not say what it refers to");
    AFFERENT_TRY(find_reference(*name, span));
    AFFERENT_TRY(codes, foresee_spans(packet, payload, span, true));
    reference_->record(predictor_->told());
    return codes;
}

// Makes the predictor foresee the packet's first span.
Result<void> PacketReceiver::find_reference(const ReferenceName& name, const Span& span) {
    const std::int64_t position = span.begin - name.spans_back;
    if (position < 0 || name.spans_back > PredictionReference::most_spans)
        return malformed("refers to what is too long ago");
    if (name.is_origin && (position != reference_->position() || !foresees_)) {
        reference_->begin(position);
        reference_->record_lost(span.begin);
    }
    if (position < reference_->position() || position > reference_->end())
        return malformed("refers to what has not been received");
    reference_->foresee(position, span.begin, *predictor_);
    reference_->move(position);
    return success();
}

// A span without a payload of its own came as presumed.
Result<std::span<const Code>> PacketReceiver::foresee_spans(const proto::Envelope& packet,
                                                            std::span<const std::byte> payload,
                                                            const Span& span, bool exactly) {
    for (std::int64_t at = span.begin; at + 1 < span.end; ++at) {
        add_events(at, predictor_->presume());
        if (reference_) reference_->record(predictor_->told());
    }
    AFFERENT_TRY(codes, predictor_->decode(payload, exactly));
    if (packet.has_check() && packet.check() != predictor_->check() % check_modulus)
        return malformed("was foreseen otherwise by its sender");
    return codes;
}

bool PacketReceiver::acknowledge(proto::Envelope& message) {
    // The rest of a packet may still come.
    if (!reference_ || !acknowledge_due_ || next_part_) return false;
    acknowledge_due_ = false;
    proto::Acknowledgement& acknowledgement = *message.mutable_acknowledgement();
    acknowledgement.Clear();
    if (!foresees_) return true;
    acknowledgement.set_position(static_cast<std::uint32_t>(reference_->end() % position_modulus) + 1);
    reference_->describe([&](std::uint32_t count) { acknowledgement.add_spans(count); });
    return true;
}

Result<std::span<const Code>> PacketReceiver::foresee(const proto::Envelope& packet, const Span& span) {
    const std::span<const std::byte> payload = std::as_bytes(std::span(packet.payload()));
    if (packet.restart())
        predictor_->restart(static_cast<std::uint64_t>(span.begin) *
                            static_cast<std::uint64_t>(layout_.span / layout_.tick));
    if (packet.part() > 0) {
        AFFERENT_TRY(codes, codec_.decode(payload));
        predictor_->add(codes);
        return codes;
    }
    return foresee_spans(packet, payload, span, packet.more());
}

Result<PacketReceiver::Span> PacketReceiver::span_of(const proto::Envelope& packet) const {
    std::uint32_t spans = spans_of(packet, layout_);
    if (spans > layout_.heartbeat_spans()) return malformed("is longer than the heartbeat allows");
    if (packet.position() == 0 && may_imply_position(packet))
        return Span{.begin = position_, .end = position_ + spans};
    if (packet.position() == 0 || packet.position() > position_modulus)
        return malformed("has an impossible position");

    AFFERENT_TRY(found, end_of(packet, spans));
    if (found < position_)
        return Error{Error::Kind::out_of_order, "packet: is older than what has been received"};
    const bool continues = found == position_ && next_part_ && packet.part() >= next_part_->number;
    if (found == position_ && !continues)
        return Error{Error::Kind::out_of_order, "packet: has been received before"};
    if (predictor_ && !reference_ && packet.spans() == 0 && !packet.has_begin()) {
        const std::int64_t since = found - (continues ? next_part_->begin : position_);
        if (since <= layout_.heartbeat_spans()) spans = static_cast<std::uint32_t>(since);
    }
    Span span{.begin = found - spans, .end = found, .continues = continues};
    if (continues) {
        if (span.begin != next_part_->begin) return malformed("has parts of different length");
        if (packet.part() > next_part_->number) {
            span.gap_begin = first_with_events(span.begin, span.end);
            span.gap_end = span.end;
        }
    } else {
        if (span.begin < position_) return malformed("begins before the end of the one before it");
        // The gap: what is missing from the packet before, the packets in between, and the parts of this one.
        span.gap_begin = next_part_ ? first_with_events(next_part_->begin, position_) : position_;
        span.gap_end = packet.part() > 0 ? span.end : span.begin;
        // The spans before the last one were silent. Where spikes are predicted, the first part tells of
        // them.
        if (span.gap_begin == span.begin && !predictor_)
            span.gap_begin = first_with_events(span.begin, span.end);
    }
    span.gap_begin = std::max(span.gap_begin, gap_end_);
    return span;
}

// It begins where the last packet ended, all parts of which have come.
bool PacketReceiver::may_imply_position(const proto::Envelope& packet) const noexcept {
    return predictor_ && !reference_ && !next_part_ && !packet.payload().empty() && packet.part() == 0 &&
           !packet.more() && !packet.has_begin() && !packet.has_count() && !packet.has_check();
}

// The position nearest to the last one, unless the packet gives it in full.
Result<std::int64_t> PacketReceiver::end_of(const proto::Envelope& packet, std::uint32_t spans) const {
    if (!packet.has_begin()) {
        const std::int64_t ahead =
            (packet.position() - 1 + position_modulus - position_ % position_modulus) % position_modulus;
        return position_ + (ahead <= position_modulus / 2 ? ahead : ahead - position_modulus);
    }
    if (packet.begin() > longest_position(layout_)) return malformed("begins at an impossible time");
    const auto end = static_cast<std::int64_t>(packet.begin()) + spans;
    if (end % position_modulus + 1 != packet.position())
        return malformed("has a begin and a position that disagree");
    return end;
}

Result<std::uint64_t> PacketReceiver::newly_lost_events(const proto::Envelope& packet, bool has_gap) const {
    if (!packet.has_count()) return 0;
    const std::uint64_t modulus = packet.payload().empty() ? silent_count_modulus : count_modulus;
    if (packet.count() >= modulus) return malformed("has an impossible running count");
    const std::uint64_t accounted = counted_events() % modulus;
    const std::uint64_t lost = (packet.count() + modulus - accounted) % modulus;
    if (lost != 0 && !has_gap && !gap_since_count_)
        return malformed("counts more events than were sent, though no packet is missing");
    return lost;
}

// `first` is where the first span that may hold events begins.
void PacketReceiver::append(std::vector<Event>& events, std::int64_t first,
                            std::span<const Code> codes) const {
    const TimePoint begin = time(first);
    const std::size_t before = events.size();
    events.resize(before + codes.size());
    std::transform(codes.begin(), codes.end(), events.begin() + static_cast<std::ptrdiff_t>(before),
                   [&](Code code) {
                       const std::uint32_t tick = addresses_.quotient(code);
                       return Event{begin + tick * layout_.tick, code - tick * addresses_.value()};
                   });
}

TimeSpan PacketReceiver::count_gap(std::int64_t begin, std::int64_t end) {
    gap_end_ = end;
    gap_since_count_ = true;
    ++counts_.gaps;
    counts_.unknown += (end - begin) * layout_.span;
    return {time(begin), time(end)};
}

}  // namespace afferent
