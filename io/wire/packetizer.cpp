#include "afferent/io/wire/packetizer.hpp"

#include <algorithm>

namespace afferent {
namespace {

// The running count costs up to five bytes. Sent this often it adds next to nothing, and the losses of a gap
// are known within 80 ms of default packets.
constexpr std::int64_t packets_between_counts = 16;

// All other fields of a packet at their longest, and the checksum.
constexpr std::size_t most_framing_bytes = 56;

}  // namespace

std::size_t most_packet_bytes(const PacketLayout& layout) {
    return most_framing_bytes + PayloadCodec::most_bytes(layout);
}

Packetizer::Packetizer(const PacketLayout& layout)
    : layout_(layout), codec_(layout), tick_(static_cast<std::uint32_t>(layout.tick.count())) {
    pending_.reserve(layout_.max_events);
    codes_.reserve(layout_.max_events);
    packet_.mutable_payload()->reserve(std::size_t{2} * layout_.max_events);
    if (layout_.encoding != Encoding::predicted) return;
    predictor_.emplace(layout_);
    if (!layout_.acknowledged) return;
    reference_.emplace(layout_);
    if (layout_.tolerance > Duration::zero()) before_.emplace(layout_);
}

std::size_t Packetizer::due() const noexcept {
    const TimePoint end = scene_start + position_ * layout_.span;
    const std::span<const Event> pending = std::span(pending_).subspan(taken_);
    const auto later = std::partition_point(pending.begin(), pending.end(),
                                            [end](const Event& event) { return event.time < end; });
    return static_cast<std::size_t>(later - pending.begin());
}

void Packetizer::collect_codes(std::size_t events) {
    const TimePoint begin = scene_start + (position_ - layout_.spans_with_events(silence_)) * layout_.span;
    codes_.resize(events);
    for (std::size_t i = 0; i < events; ++i) {
        const Event& event = pending_[taken_ + i];
        assert(event.time >= begin && event.address < layout_.addresses);
        const auto since = static_cast<std::uint32_t>((event.time - begin).count());
        codes_[i] = tick_.quotient(since) * layout_.addresses + event.address;
    }
    taken_ += events;
    // On average this moves each event at most once, however far ahead events were pushed.
    if (2 * taken_ >= pending_.size()) {
        pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(taken_));
        taken_ = 0;
    }
    // Sorted by time they are not sorted by address within a tick.
    sorter_.sort(codes_);
    rest_ = codes_;
}

bool Packetizer::collect(std::size_t events) {
    if (events == 0 || !closes()) return false;
    collect_codes(events);
    return true;
}

bool Packetizer::foresee(std::size_t events) {
    if (restart_due_) {
        // What has happened since the last packet is lost with it.
        events_ += foreseen_;
        foreseen_ = 0;
        silence_ = 1;
        predictor_->restart(static_cast<std::uint64_t>(position_ - 1) *
                            static_cast<std::uint64_t>(layout_.span / layout_.tick));
        restarts_ = true;
        restart_due_ = false;
    }
    collect_codes(events);
    const std::size_t room = layout_.max_events - predictor_->waiting();
    const bool more = rest_.size() > room;
    const bool surprises =
        encode(rest_.first(std::min(rest_.size(), room)), {.exactly = more, .last = ending_});
    rest_ = rest_.subspan(std::min(rest_.size(), room));
    foreseen_ += predictor_->told().size();
    if (reference_) reference_->record(predictor_->told());
    return surprises || more;
}

bool Packetizer::encode(std::span<const Code> codes, SpikePredictor::Manner manner) {
    if (before_) *before_ = *predictor_;
    const bool surprises = predictor_->encode(codes, surprises_, manner);
    if (!before_ || manner.exactly || !surprises) return surprises;
    // What is told exactly costs a few bits, and spares the packets that would follow until it is
    // acknowledged.
    *predictor_ = *before_;
    manner.exactly = true;
    return predictor_->encode(codes, surprises_, manner);
}

bool Packetizer::acknowledge(const proto::Acknowledgement& acknowledgement) {
    if (!reference_ || acknowledgement.position() > position_modulus) return false;
    if (acknowledgement.position() == 0) {
        start_over_ = true;
        return true;
    }
    const std::int64_t behind =
        (position_ % position_modulus + position_modulus - (acknowledgement.position() - 1)) %
        position_modulus;
    const std::int64_t position = position_ - behind;
    if (behind > position_modulus / 2 || position > position_ - silence_) return false;
    // One that has been overtaken says nothing new.
    if (position <= reference_->position()) return true;
    if (reference_->mark(position, acknowledgement.spans())) reference_->move(position);
    return true;
}

// After a packet: the next is told from what is acknowledged by then.
void Packetizer::follow_reference() {
    if (reference_->fill() > 0.5 || start_over_) reference_->begin(position_);
    start_over_ = false;
    told_from_ = reference_->position();
    told_from_origin_ = reference_->is_origin();
    reference_->foresee(told_from_, position_, *predictor_);
}

void Packetizer::name_reference() {
    named_ = told_from_;
    const auto back = static_cast<std::uint32_t>(position_ - silence_ - told_from_);
    append_name({back, told_from_origin_}, *packet_.mutable_payload());
}

void Packetizer::count_what_was_foreseen() {
    if (!predictor_) return;
    events_ += foreseen_;
    foreseen_ = 0;
    packet_.set_restart(restarts_);
    restarts_ = false;
}

const proto::Envelope& Packetizer::next_part(std::uint32_t part) {
    start_packet(layout_.gathered_spans);
    const std::int64_t between_counts = packets_between_counts * layout_.gathered_spans;
    const bool regular = position_ / between_counts != told_at_ / between_counts;
    if (part == 0 && (count_due_ || (regular && !in_order()))) tell_count(count_modulus);
    if (predictor_ && part == 0) {
        packet_.mutable_payload()->clear();
        if (reference_) name_reference();
        packet_.mutable_payload()->append(surprises_);
        packet_.set_part(0);
        packet_.set_more(!rest_.empty());
        count_what_was_foreseen();
        if (regular && rest_.empty()) tell_check();
        if (in_order()) imply_position();
        return packet_;
    }
    const std::size_t events = std::min<std::size_t>(rest_.size(), layout_.max_events);
    codec_.encode(rest_.first(events), *packet_.mutable_payload(), layout_.spans_with_events(silence_));
    if (predictor_) predictor_->add(rest_.first(events));
    if (reference_) reference_->record_more(predictor_->told());
    rest_ = rest_.subspan(events);
    packet_.set_part(part);
    packet_.set_more(!rest_.empty());
    events_ += events;
    return packet_;
}

const proto::Envelope& Packetizer::silent_packet() {
    // In silence, too, so that the other end can forget what is before it.
    const bool named = reference_ && (foreseen_ > 0 || named_ != told_from_);
    start_packet(named ? layout_.gathered_spans : layout_.heartbeat_spans());
    packet_.clear_payload();
    packet_.clear_part();
    packet_.clear_more();
    if (named) name_reference();
    if (count_due_ || (!in_order() && told_events_ != events_))
        tell_count(named ? count_modulus : silent_count_modulus);
    count_what_was_foreseen();
    if (predictor_ && predictor_->check() != told_check_ && (in_order() || named)) tell_check();
    silence_ = 0;
    return packet_;
}

void Packetizer::start_packet(std::uint32_t implied_spans) {
    packet_.set_position(static_cast<std::uint32_t>(position_ % position_modulus) + 1);
    const bool implied = in_order() ? begins_due_ == 0 : silence_ == implied_spans;
    packet_.set_spans(implied ? 0 : silence_);
    packet_.clear_count();
    packet_.clear_begin();
    packet_.clear_restart();
    packet_.clear_check();
    if (begins_due_ > 0) {
        --begins_due_;
        packet_.set_begin(static_cast<std::uint64_t>(position_ - silence_));
    }
    ++packets_;
}

// The first packet says where it ends, and so do those with a check: an error of the place does not last.
void Packetizer::imply_position() {
    if (packets_ == 1 || packet_.has_begin() || packet_.has_check() || packet_.has_count() || packet_.more())
        return;
    packet_.clear_position();
    packet_.set_spans(silence_ == layout_.gathered_spans ? 0 : silence_);
}

void Packetizer::tell_count(std::uint64_t modulus) {
    packet_.set_count(static_cast<std::uint32_t>(events_ % modulus));
    told_at_ = position_;
    told_events_ = events_;
    count_due_ = false;
}

void Packetizer::tell_check() {
    told_check_ = predictor_->check();
    told_at_ = position_;
    packet_.set_check(told_check_ % check_modulus);
}

}  // namespace afferent
