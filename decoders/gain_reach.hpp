// Whether sensors, rates and decoder can bring the gain to 0 at its limit.
#pragma once

#include <optional>
#include <string>

#include "afferent/decoders/decoded_afferents.hpp"
#include "afferent/decoders/decoder_parameters.hpp"
#include "afferent/decoders/emg_gain.hpp"

namespace afferent {

// What a decoder makes of a grip force that is held at the limit of the gain, once the neurons have adapted.
struct GainReach {
    double limit_n;
    // The largest grip force that the sensors can tell, and what they have to tell: more than the limit, by
    // how well they are known.
    double sensed_n;
    double wanted_n;
    // The mean rate of the sustained afferents at the limit, once adapted.
    double rate_hz;
    // How long the decoder may wait for an afferent's next spike.
    double longest_wait_s;
    // The grip force from which on the gain stays 0 even where an estimate is lowest, just before the next
    // spike. None: no force does that.
    std::optional<double> closes_n;

    bool senses_limit() const noexcept { return sensed_n >= wanted_n; }
    bool closes_at_limit() const noexcept;
    // Whether the next spike comes before a force can rise unnoticed.
    bool hears_in_time() const noexcept;
    bool reaches() const noexcept { return senses_limit() && closes_at_limit() && hears_in_time(); }
};

// What decodes the grip force, and the gain that goes by it. The decoder can be constructed.
struct GainLoop {
    const DecoderParameters& decoder;
    const DecodedAfferents& afferents;
    const EmgGain::Parameters& gain;
};

GainReach gain_reach(const GainLoop& loop);

// Why the gain does not reach 0 at its limit, with the numbers; empty: it does.
std::string unreachable_limit(const GainLoop& loop);

}  // namespace afferent
