#include "afferent/io/wire/packetizer.hpp"

#include <algorithm>

namespace afferent {
namespace {

// The running count costs up to five bytes. Sent this often it adds next to nothing, and the losses of a gap
// are known within 80 ms of default packets.
constexpr std::int64_t packets_between_counts = 16;

// All other fields of a packet at their longest, and the checksum.
constexpr std::size_t most_framing_bytes = 48;

}  // namespace

std::size_t most_packet_bytes(const PacketLayout& layout) {
    return most_framing_bytes + PayloadCodec::most_bytes(layout);
}

Packetizer::Packetizer(const PacketLayout& layout)
    : layout_(layout), codec_(layout), tick_(static_cast<std::uint32_t>(layout.tick.count())) {
    pending_.reserve(layout_.max_events);
    codes_.reserve(layout_.max_events);
    packet_.mutable_payload()->reserve(std::size_t{2} * layout_.max_events);
    if (layout_.encoding == Encoding::predicted) predictor_.emplace(layout_);
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
    const bool surprises = predictor_->encode(rest_.first(std::min(rest_.size(), room)), surprises_,
                                              {.exactly = more, .last = ending_});
    rest_ = rest_.subspan(std::min(rest_.size(), room));
    foreseen_ += predictor_->told();
    if (more && surprises_.empty()) surprises_.push_back('\0');
    return surprises || more;
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
    // A check of what is foreseen covers the count.
    if (part == 0 && (count_due_ || (regular && !predictor_))) tell_count(count_modulus);
    if (predictor_ && part == 0) {
        packet_.mutable_payload()->assign(surprises_);
        packet_.set_part(0);
        packet_.set_more(!rest_.empty());
        count_what_was_foreseen();
        if (regular && rest_.empty()) tell_check();
        return packet_;
    }
    const std::size_t events = std::min<std::size_t>(rest_.size(), layout_.max_events);
    codec_.encode(rest_.first(events), *packet_.mutable_payload(), layout_.spans_with_events(silence_));
    if (predictor_) predictor_->add(rest_.first(events));
    rest_ = rest_.subspan(events);
    packet_.set_part(part);
    packet_.set_more(!rest_.empty());
    events_ += events;
    return packet_;
}

const proto::Envelope& Packetizer::silent_packet() {
    start_packet(layout_.heartbeat_spans());
    packet_.clear_payload();
    packet_.clear_part();
    packet_.clear_more();
    if (count_due_ || (!predictor_ && told_events_ != events_)) tell_count(silent_count_modulus);
    count_what_was_foreseen();
    if (predictor_ && predictor_->check() != told_check_) tell_check();
    silence_ = 0;
    return packet_;
}

void Packetizer::start_packet(std::uint32_t implied_spans) {
    packet_.set_position(static_cast<std::uint32_t>(position_ % position_modulus) + 1);
    // Where spikes are predicted, nothing is lost on the way: it begins where the one before it ended.
    const bool implied = predictor_ ? begins_due_ == 0 : silence_ == implied_spans;
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
