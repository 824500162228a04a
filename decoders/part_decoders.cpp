#include "afferent/decoders/part_decoders.hpp"

#include <algorithm>
#include <numeric>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {
namespace {

// A longer span is taken in pieces, which are as well known as the whole.
constexpr std::size_t events_at_once = 4096;

DecodedAfferents with_own_addresses(DecodedAfferents afferents) {
    Address address = 0;
    for (DecodedAfferents::Afferent& afferent : afferents.afferents) afferent.address = address++;
    afferents.addresses = address;
    return afferents;
}

Estimate part_of(const Estimate& grip, double share) {
    return {.force_n = share * grip.force_n,
            .sigma_n = share * grip.sigma_n,
            .rate_hz = grip.rate_hz,
            .doubt = grip.doubt};
}

}  // namespace

PartDecoders::PartDecoders(const DecoderParameters& parameters, const std::vector<Part>& parts) {
    require(!parts.empty(), "parts", "at least one", 0);
    const std::size_t addresses = parts.front().afferents.addresses;
    begins_.assign(addresses + 1, 0);
    for (const Part& part : parts) {
        part.afferents.check();
        require(part.afferents.addresses == addresses, "parts", "of the same stream",
                static_cast<double>(part.afferents.addresses));
        for (const auto& afferent : part.afferents.afferents) ++begins_[afferent.address + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    places_.resize(begins_.back());
    std::vector<std::uint32_t> filled(begins_.begin(), begins_.end() - 1);
    decoders_.reserve(parts.size());
    shares_.reserve(parts.size());
    for (const Part& part : parts) {
        const auto index = static_cast<std::uint32_t>(decoders_.size());
        Address own = 0;
        for (const auto& afferent : part.afferents.afferents)
            places_[filled[afferent.address]++] = {index, own++};
        decoders_.push_back(make_decoder(parameters, with_own_addresses(part.afferents)));
        shares_.push_back(part.share);
    }
    // At least one event fits, even one that belongs to every part.
    sorted_.resize(std::max(events_at_once, decoders_.size()));
    ends_.resize(decoders_.size());
}

std::size_t PartDecoders::sort_by_part(std::span<const Event> events) noexcept {
    std::fill(ends_.begin(), ends_.end(), 0);
    std::size_t sorted = 0;
    std::size_t count = 0;
    for (; count < events.size(); ++count) {
        const auto places = places_of(events[count].address);
        if (sorted + places.size() > sorted_.size()) break;
        sorted += places.size();
        for (const Position& place : places) ++ends_[place.part];
    }
    // Where the events of each part begin; as they are filled in, these move on to where they end.
    std::exclusive_scan(ends_.begin(), ends_.end(), ends_.begin(), std::uint32_t{0});
    for (const Event& event : events.first(count))
        for (const Position& place : places_of(event.address))
            sorted_[ends_[place.part]++] = {event.time, place.address};
    return count;
}

void PartDecoders::observe(TimePoint begin, TimePoint end, std::span<const Event> events) {
    for (bool is_first = true; is_first || !events.empty(); is_first = false) {
        events = events.subspan(sort_by_part(events));
        std::uint32_t first = 0;
        for (std::size_t i = 0; i < decoders_.size(); ++i) {
            // Every part is told of the span by the first piece; later pieces go only to the parts that have
            // events in them.
            if (is_first || ends_[i] > first)
                decoders_[i].observe(begin, end, std::span(sorted_).subspan(first, ends_[i] - first));
            first = ends_[i];
        }
    }
}

void PartDecoders::lose(TimePoint begin, TimePoint end) {
    for (GripDecoder& decoder : decoders_) decoder.lose(begin, end);
}

void PartDecoders::presume_silence(TimePoint until) {
    for (GripDecoder& decoder : decoders_) decoder.presume_silence(until);
}

Duration PartDecoders::history() const {
    Duration longest{};
    for (const GripDecoder& decoder : decoders_) longest = std::max(longest, decoder.history());
    return longest;
}

void PartDecoders::restart(TimePoint start) {
    for (GripDecoder& decoder : decoders_) decoder.restart(start);
}

void PartDecoders::resume_after(TimePoint start, TimePoint heard_until, const Estimate& last) {
    for (std::size_t i = 0; i < decoders_.size(); ++i)
        decoders_[i].resume_after(start, heard_until, part_of(last, shares_[i]));
}

void PartDecoders::correct(const Estimate& last) {
    for (std::size_t i = 0; i < decoders_.size(); ++i) decoders_[i].correct(part_of(last, shares_[i]));
}

PartDecoders::Snapshot PartDecoders::snapshot() const {
    Snapshot all;
    all.reserve(decoders_.size());
    for (const GripDecoder& decoder : decoders_) all.push_back(decoder.snapshot());
    return all;
}

void PartDecoders::resume(const Snapshot& snapshot) {
    require(snapshot.size() == decoders_.size(), "snapshot.parts", "one for each part",
            static_cast<double>(snapshot.size()));
    const Snapshot before = this->snapshot();
    std::size_t resumed = 0;
    try {
        for (; resumed < decoders_.size(); ++resumed) decoders_[resumed].resume(snapshot[resumed]);
    } catch (const ParameterError&) {
        while (resumed-- > 0) decoders_[resumed].resume(before[resumed]);
        throw;
    }
}

std::size_t PartDecoders::bytes() const {
    std::size_t bytes = sizeof(*this) + shares_.capacity() * sizeof(double) +
                        (begins_.capacity() + ends_.capacity()) * sizeof(std::uint32_t) +
                        places_.capacity() * sizeof(Position) + sorted_.capacity() * sizeof(Event);
    for (const GripDecoder& decoder : decoders_) bytes += decoder.bytes();
    return bytes;
}

}  // namespace afferent
