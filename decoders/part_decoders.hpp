// A decoder for each part of a hand, such as a patch or an element, from the events of its own afferents.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/grip_decoder.hpp"

namespace afferent {

// Estimates the force on each part, in the part's own newtons, as a decoder estimates the grip force
// (decoder.hpp tells what the calls mean). An afferent may belong to several parts.
//
// A span costs one call for each part, and an event one for each part that it belongs to. Memory: that of a
// decoder for each part, whatever the number of addresses, and eight bytes for each address. Allocates
// nothing after construction, as long as the decoders do not.
class PartDecoders {
  public:
    struct Part {
        // With the addresses of the whole stream; drives are per newton of the part, and shares are of its
        // force.
        DecodedAfferents afferents;
        // Its share of the grip force: while nothing is known of the part, this share of the grip's estimate
        // stands for it.
        double share = 0;

        friend bool operator==(const Part&, const Part&) = default;
    };
    using Snapshot = std::vector<GripDecoder::Snapshot>;

    // At least one part, of the same stream. Throws ParameterError, as the decoder does of a part that it
    // cannot decode.
    PartDecoders(const DecoderParameters& parameters, const std::vector<Part>& parts);

    std::size_t size() const noexcept { return decoders_.size(); }

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    void lose(TimePoint begin, TimePoint end);
    void presume_silence(TimePoint until);
    TimePoint heard_until() const { return decoders_.front().heard_until(); }

    Estimate estimate(std::size_t part, TimePoint now) { return decoders_[part].estimate(now); }
    Duration history() const;

    void restart(TimePoint start);
    // `last` is the grip's.
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last);
    void correct(const Estimate& last);
    // `last` is the part's own.
    void correct(std::size_t part, const Estimate& last) { decoders_[part].correct(last); }
    Snapshot snapshot() const;
    // Throws ParameterError, and changes nothing, if the snapshot is of other parts or of another decoder.
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const;

  private:
    // The address of an afferent within its part.
    struct Position {
        std::uint32_t part;
        Address address;
    };
    std::span<const Position> places_of(Address address) const noexcept {
        return std::span(places_).subspan(begins_[address], begins_[address + 1] - begins_[address]);
    }
    // Sorts by part as many of the first events as there is room for; returns how many.
    std::size_t sort_by_part(std::span<const Event> events) noexcept;

    std::vector<GripDecoder> decoders_;
    std::vector<double> shares_;
    std::vector<std::uint32_t> begins_;  // by address, into places_
    std::vector<Position> places_;
    // The events of a piece of a span, part after part, and where those of each part end.
    std::vector<Event> sorted_;
    std::vector<std::uint32_t> ends_;
};

}  // namespace afferent
