// The closed list of decoders, and the decoder that a scene has chosen from it.
#pragma once

#include <variant>

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/exponential.hpp"
#include "afferent/decoders/filter.hpp"
#include "afferent/decoders/inverse_interval.hpp"
#include "afferent/decoders/inversion.hpp"
#include "afferent/decoders/sliding_window.hpp"

namespace afferent {

template <Decoder... D>
struct DecoderList {
    using Any = std::variant<D...>;
    using Parameters = std::variant<typename D::Parameters...>;
    using Snapshot = std::variant<typename D::Snapshot...>;
};

// To add a decoder, add its header above and its name here; the laws that every decoder keeps are then tested
// for it.
using Decoders = DecoderList<SlidingWindow, Exponential, InverseInterval, Inversion, Filter>;

using DecoderParameters = Decoders::Parameters;

// Any of the decoders behind the same interface: a Decoder itself (decoder.hpp), with one visit for each
// call.
class GripDecoder {
  public:
    using Parameters = DecoderParameters;
    using Snapshot = Decoders::Snapshot;

    // The decoder whose parameters these are. Throws ParameterError, as that one does.
    GripDecoder(const Parameters& parameters, const DecodedAfferents& afferents);

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    void lose(TimePoint begin, TimePoint end);
    void presume_silence(TimePoint until);
    TimePoint heard_until() const;

    Estimate estimate(TimePoint now);
    // Whether the decoder ignores an afferent at present, because it contradicts the others. Only the filter
    // does.
    bool left_out(Address address) const;
    Duration history() const;

    void restart(TimePoint start);
    void resume_after(TimePoint start, TimePoint heard_until, const Estimate& last);
    void correct(const Estimate& last);
    Snapshot snapshot() const;
    // Throws ParameterError, and changes nothing, if the snapshot is of another decoder or other afferents.
    void resume(const Snapshot& snapshot);

    std::size_t bytes() const;

  private:
    Decoders::Any decoder_;
};

static_assert(Decoder<GripDecoder>);

inline GripDecoder make_decoder(const DecoderParameters& parameters, const DecodedAfferents& afferents) {
    return {parameters, afferents};
}

}  // namespace afferent
