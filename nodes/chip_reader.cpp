#include "afferent/nodes/chip_reader.hpp"

#include <algorithm>
#include <cmath>

#include "afferent/io/wire/handshake.hpp"
#include "afferent/io/wire/packetizer.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/scene/chip_fingerprint.hpp"
#include "afferent/scene/plan_bounds.hpp"

namespace afferent {
namespace {

// A packet that ends so much later than it arrives is of a chip that has begun again.
constexpr Duration most_ahead = 100ms;
// So many refused packets in a row are those of a chip that has begun again.
constexpr std::uint32_t most_refused = 3;
// A chip that has not said which it is by so many packets does not say it at all.
constexpr std::uint64_t said_by_then = 100;
constexpr Duration judged_every = 250ms;
constexpr Duration tell_again_after = 10s;
constexpr std::size_t most_notes = 16;
constexpr std::size_t most_gaps = 64;

std::size_t longest_frame(const Plan& plan) {
    const std::size_t readings = 64 + 5 * std::size_t{plan.elements};
    return std::max(most_packet_bytes(*plan.packets), readings);
}

}  // namespace

ChipReader::ChipReader(const Plan& plan, Coprocessor* emulator)
    : plan_(plan),
      fingerprint_(chip_fingerprint(plan).value()),
      fired_(plan.addresses),
      cobs_(longest_frame(plan)) {
    most_per_second_.reserve(plan.addresses);
    for (const PatchPlan& patch : plan.patches)
        for (std::uint32_t i = 0; i < patch.afferents(); ++i)
            most_per_second_.push_back(highest_rate_hz(plan, patch, i));
    if (emulator) comparison_.emplace(plan, *emulator);
}

void ChipReader::read(MonotonicTime at, TimePoint now, std::span<const std::byte> bytes) {
    at_ = at;
    const std::uint64_t refused = cobs_.refused();
    cobs_.read(bytes, [&](std::span<const std::byte> datagram) { frame(now, datagram); });
    if (comparison_ && cobs_.refused() != refused) comparison_->lose();
}

void ChipReader::frame(TimePoint now, std::span<const std::byte> datagram) {
    proto::Envelope& message = message_;
    if (!read_datagram(datagram, message, report_.frames)) {
        // It may have been readings.
        if (comparison_) comparison_->lose();
        return;
    }
    switch (message.content_case()) {
        case proto::Envelope::CONTENT_NOT_SET:
            return packet(now, message);
        case proto::Envelope::kChip:
            return hello(now, message.chip());
        case proto::Envelope::kReadings:
            return readings(message.readings());
        default:
            ++report_.frames.refused;
    }
}

void ChipReader::hello(TimePoint now, const proto::ChipHello& hello) {
    if (hello.version() == wire_version && hello.fingerprint() == fingerprint_) {
        is_the_scenes_ = true;
        return;
    }
    if (std::exchange(is_the_scenes_, false)) {
        count_session();
        receiver_.reset();
    }
    // A chip says it ten times a second.
    if (now < tell_another_at_) return;
    tell_another_at_ = now + tell_again_after;
    const PacketLayout& layout = *plan_.packets;
    tell("another chip than the scene's is on the line, and its packets are not used: wire version " +
         std::to_string(hello.version()) + ", " + std::to_string(hello.addresses()) +
         " afferents, packets of " + std::to_string(hello.span_ns() / 1000) + " us; here version " +
         std::to_string(wire_version) + ", " + std::to_string(layout.addresses) + ", " +
         std::to_string(layout.span / 1us) +
         " us. If these are the same, neurons or sensors are not: export the scene again");
}

void ChipReader::readings(const proto::Readings& readings) {
    if (!comparison_ || !is_the_scenes_) return;
    // In nanoseconds it is no overflow for a hundred years.
    constexpr std::uint64_t latest = std::uint64_t{1} << 61;
    const auto tick = static_cast<std::uint64_t>(comparison_->neuron_tick().count());
    if (readings.tick() < latest / tick)
        near_ = static_cast<std::int64_t>(readings.tick() * tick) / plan_.packets->span.count();
    if (receiver_) comparison_->read(readings);
}

void ChipReader::packet(TimePoint now, const proto::Envelope& packet) {
    if (!is_the_scenes_) {
        if (++report_.unknown_packets == said_by_then && tell_another_at_ == TimePoint::min())
            tell("the chip does not say which it is, and its packets are not used");
        return;
    }
    if (!receiver_ && !follow(now, packet)) return;
    if (!counted_ && packet.has_count()) {
        const auto standing = receiver_->standing(packet);
        if (standing && !standing->misses_some) resume(receiver_->position(), packet);
    }
    const TimePoint latest = now - offset_ + most_ahead;
    Result<Reception> received = receiver_->receive(packet, latest);
    if (!received) {
        // Serial lines neither reorder nor repeat.
        const bool begins_again = received.error().kind == Error::Kind::out_of_order && packet.has_begin();
        if (!begins_again && ++refused_in_a_row_ < most_refused) {
            ++report_.refused_packets;
            return;
        }
        if (!follow(now, packet)) return;
        // A line that is bad for long is told of now and then.
        if (now >= tell_again_at_) {
            tell("the chip has begun again, or its packets do not follow each other");
            tell_again_at_ = now + tell_again_after;
        }
        received = receiver_->receive(packet, now - offset_ + most_ahead);
        if (!received) {
            ++report_.refused_packets;
            receiver_.reset();
            return;
        }
    }
    refused_in_a_row_ = 0;
    Reception reception = received.value();
    const bool is_plausible = plausible(reception);
    if (!is_plausible) ++report_.implausible_packets;
    if (!is_plausible || !reception.usable()) reception = receiver_->discard(reception);
    if (comparison_) comparison_->compare(reception);
    take_over(reception);
    compare_clocks(now, reception.known.end + offset_);
}

// Begins with any packet.
bool ChipReader::follow(TimePoint now, const proto::Envelope& packet) {
    const std::uint32_t spans = spans_of(packet, *plan_.packets);
    if (spans > plan_.packets->heartbeat_spans() || packet.position() > position_modulus) return false;
    resume(begin_of(packet, spans), packet);
    const Duration end = (static_cast<std::int64_t>(receiver_->position()) + spans) * plan_.packets->span;
    offset_ = whole_spans(now - scene_start - end);
    add_gap(known_until_, receiver_->end() + offset_);
    window_begin_ = now;
    earliest_ = Duration::max();
    judged_since_.reset();
    refused_in_a_row_ = 0;
    ++report_.beginnings;
    if (comparison_) {
        comparison_->restart(receiver_->end());
        if (receiver_->position() > 0) comparison_->lose();
    }
    return true;
}

// A packet says where it ends modulo position_modulus; readings say in full about where that is.
std::uint64_t ChipReader::begin_of(const proto::Envelope& packet, std::uint32_t spans) const noexcept {
    if (packet.has_begin()) return packet.begin();
    constexpr auto modulus = std::int64_t{position_modulus};
    std::int64_t ahead = (packet.position() - 1 - near_) % modulus;
    if (ahead > modulus / 2) ahead -= modulus;
    if (ahead < -modulus / 2) ahead += modulus;
    const std::int64_t begin = near_ + ahead - spans;
    return static_cast<std::uint64_t>(begin < 0 ? begin + modulus : begin);
}

// Until a packet says how many events there were before it, lost ones are not counted.
void ChipReader::resume(std::uint64_t begin, const proto::Envelope& packet) {
    count_session();
    receiver_.emplace(*plan_.packets);
    receiver_->resume(begin, packet.count());
    counted_ = packet.has_count();
}

// An afferent has one event more than its highest rate in the time of a packet, at most, and another by the
// tick.
bool ChipReader::plausible(const Reception& reception) {
    const double span_s = seconds(reception.known.end) - seconds(reception.known.begin);
    bool fits = true;
    for (const Event& event : reception.events)
        fits = ++fired_[event.address] <= most_per_second_[event.address] * span_s + 2 && fits;
    for (const Event& event : reception.events) fired_[event.address] = 0;
    return fits;
}

void ChipReader::take_over(const Reception& reception) {
    if (reception.gap) add_gap(reception.gap->begin + offset_, reception.gap->end + offset_);
    const TimePoint end = reception.known.end + offset_;
    known_until_ = std::max(known_until_, end);
    if (end <= taken_until_) {
        report_.late_events += reception.events.size();
        return;
    }
    for (const Event& event : reception.events) {
        TimePoint time = std::max(event.time + offset_, taken_until_ + Duration(1));
        if (!events_.empty()) time = std::max(time, events_.back().time);
        events_.push_back({time, event.address});
    }
}

void ChipReader::compare_clocks(TimePoint now, TimePoint end) {
    earliest_ = std::min(earliest_, now - end);
    if (!judged_since_) judged_since_ = {end - offset_, at_};
    const double for_s = Seconds(at_ - judged_since_->second).count();
    if (for_s >= 1)
        report_.clock_ppm = 1e6 * (Seconds(end - offset_ - judged_since_->first).count() / for_s - 1);
    if (now - window_begin_ < judged_every) return;
    const Duration late = std::exchange(earliest_, Duration::max());
    window_begin_ = now;
    ahead_ = -late;
    const Duration span = plan_.packets->span;
    if (late > -span && late < span) return;
    if (report_.clock_jumps++ == 0)
        tell("the chip's clock differs by more than " +
             std::to_string(static_cast<int>(1e6 * Pacer::most_correction)) +
             " ppm, or its line is slower than its packets: spans are skipped");
    offset_ += whole_spans(late);
}

Duration ChipReader::whole_spans(Duration duration) const noexcept {
    const Duration span = plan_.packets->span;
    const Duration half = duration < Duration::zero() ? -span / 2 : span / 2;
    return (duration + half) / span * span;
}

bool ChipReader::knows(TimePoint begin, TimePoint end) const noexcept {
    return end <= known_until_ && std::ranges::none_of(gaps_, [&](const TimeSpan& gap) {
               return gap.begin < end && gap.end > begin;
           });
}

std::span<const Event> ChipReader::take(TimePoint until) {
    // What comes later of this time has been told as unknown.
    if (known_until_ <= until) add_gap(known_until_, until + Duration(1));
    taken_until_ = std::max(taken_until_, until);
    taken_.clear();
    while (!events_.empty() && events_.front().time <= until) {
        taken_.push_back(events_.front());
        events_.pop_front();
    }
    std::ranges::sort(taken_, [](const Event& a, const Event& b) {
        return a.time != b.time ? a.time < b.time : a.address < b.address;
    });
    return taken_;
}

void ChipReader::add_gap(TimePoint begin, TimePoint end) {
    if (begin >= end) return;
    // No packet to the hand covers more than a heartbeat: older gaps are never asked for again.
    std::erase_if(gaps_, [&](const TimeSpan& gap) {
        return gap.end + plan_.packets->heartbeat_spans() * plan_.packets->span < taken_until_;
    });
    if (!gaps_.empty() && (begin <= gaps_.back().end || gaps_.size() == most_gaps))
        gaps_.back().end = std::max(gaps_.back().end, end);
    else
        gaps_.push_back({begin, end});
}

void ChipReader::tell(std::string note) {
    if (notes_.size() < most_notes) notes_.push_back(std::move(note));
}

std::optional<std::string> ChipReader::next_note() {
    if (comparison_)
        if (auto note = comparison_->next_note()) return note;
    if (notes_.empty()) return std::nullopt;
    std::string note = std::move(notes_.front());
    notes_.pop_front();
    return note;
}

// The counts of a receiver that is about to be given up.
void ChipReader::count_session() {
    if (!receiver_) return;
    const PacketCounts& counts = receiver_->counts();
    report_.packets += counts.packets;
    report_.gaps += counts.gaps;
    report_.lost_events += counts.lost_events;
}

ChipReport ChipReader::report() const {
    ChipReport report = report_;
    report.refused_bytes = cobs_.refused();
    if (receiver_) {
        const PacketCounts& counts = receiver_->counts();
        report.packets += counts.packets;
        report.gaps += counts.gaps;
        report.lost_events += counts.lost_events;
    }
    if (comparison_) report.comparison = comparison_->counts();
    return report;
}

}  // namespace afferent
