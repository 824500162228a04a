// A decoder chosen at run time by its parameters. Included by programs that decode events without a scene.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "afferent/decoders/decoder.hpp"
#include "afferent/decoders/decoder_parameters.hpp"

namespace afferent {

// Holds any one of the decoders and is a Decoder itself (decoder.hpp). Each call dispatches once.
class GripDecoder {
  public:
    using Parameters = DecoderParameters;
    struct Snapshot {
        struct State;
        std::shared_ptr<const State> state;
        bool operator==(const Snapshot& other) const;
    };

    // Constructs the decoder to which the parameters belong. Throws ParameterError if they or the afferents
    // are invalid.
    GripDecoder(const Parameters& parameters, const DecodedAfferents& afferents);
    ~GripDecoder();
    GripDecoder(const GripDecoder&);
    GripDecoder& operator=(const GripDecoder&);
    GripDecoder(GripDecoder&&) noexcept;
    GripDecoder& operator=(GripDecoder&&) noexcept;

    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    void lose(TimePoint begin, TimePoint end);
    void presume_silence(TimePoint until);
    TimePoint heard_until() const;

    Estimate estimate(TimePoint now);
    // Whether the decoder ignores this afferent at present, because it contradicts the others. Always false
    // except with the filter.
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
    class Impl;
    std::unique_ptr<Impl> impl_;
};

static_assert(Decoder<GripDecoder>);

inline GripDecoder make_decoder(const DecoderParameters& parameters, const DecodedAfferents& afferents) {
    return {parameters, afferents};
}

}  // namespace afferent
