// The schemes that are compared: what a link may carry instead of events, each measured in the same frames.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/link_activity.hpp"
#include "bench/sent_counts.hpp"

namespace afferent {

struct SchemeResult {
    std::string scheme;
    std::optional<Duration> tick = {};       // where there are events
    std::optional<Duration> deadline = {};   // of packets, or from sample to sample
    std::optional<double> delta_n = {};      // of send-on-delta
    std::optional<double> dead_band = {};    // as a fraction of the value sent last
    std::optional<Duration> tolerance = {};  // where spikes are predicted
    std::uint64_t bytes = 0;                 // framing and heartbeats included
    // Over the entropy of neurons that fire at random (Poisson) at the known rate.
    std::optional<double> poisson_ratio = {};
    // Bits an event, without framing, where spikes are predicted to the tick: at most so much is the causal
    // entropy, that of the train given the neurons' law and what came before. Beside it, the entropy of
    // Poisson neurons of the same mean rate.
    std::optional<double> causal_bits = {};
    std::optional<double> poisson_bits = {};
    // Time for an event, or for a sample where samples are sent; coding only, without framing.
    std::optional<double> encode_ns = {};
    std::optional<double> decode_ns = {};
    // The RMS error of the force decoded from it, as well as the scheme allows (bench/decoding_bench.hpp);
    // not measured on more than 10,000 elements.
    std::optional<double> rms_n = {};
};

// Packets as the wire has them. Where the neurons are Poisson, `poisson_rate_hz` is their rate and gives the
// ratio to their entropy.
SchemeResult measure_events(const LinkActivity& activity, Duration tick, Duration deadline,
                            std::optional<double> poisson_rate_hz);
// The same with link.encoding PREDICTED, by the law of the scene's neurons; nothing where there are too many
// for it.
std::optional<SchemeResult> measure_predicted(const LinkActivity& activity, Duration tick, Duration deadline,
                                              Duration tolerance);
// Events as Protobuf's own fields, in the same packets.
SchemeResult measure_repeated_messages(const LinkActivity& activity, Duration tick, Duration deadline);
SchemeResult measure_packed_columns(const LinkActivity& activity, Duration tick, Duration deadline);
// Every sample, in 12 or 16 bits.
SchemeResult measure_raw(const LinkActivity& activity, unsigned bits);
// The difference of every sample from its predecessor, as a varint.
SchemeResult measure_delta_varint(const LinkActivity& activity);
// The difference of every sample from its predecessor, as changes of its element are coded
// (change_coder.hpp).
SchemeResult measure_delta_coded(const LinkActivity& activity);
// Send-on-delta: a sample, with its element, whenever it has changed by delta since it was last sent.
SchemeResult measure_send_on_delta(const LinkActivity& activity, double delta_n);
// The same, where both ends presume that a count goes on along a line: whenever it is delta away from that.
SchemeResult measure_linear_prediction(const LinkActivity& activity, double delta_n);
// The relative dead band of kinaesthetic codecs (IEEE 1918.1.1; Hinterseer et al. 2008): whenever it has
// changed by that fraction of the value sent last, and by delta.
SchemeResult measure_dead_band(const LinkActivity& activity, double fraction, double delta_n);

// Near 0 a dead band is no narrower than `least` counts, nor than four standard deviations of a reading, so
// that noise is not sent.
ChangeRule dead_band_rule(const LinkActivity& activity, double fraction, int least);

// The bytes alone. One payload for each span, in the wire's own frames; an empty one is silence, and is sent
// at the heartbeat only.
std::uint64_t framed_bytes(const std::vector<std::string>& payloads, Duration span);

// A force in whole counts, at least one.
int counts_of(double force_n, const LinkActivity& activity);

}  // namespace afferent
