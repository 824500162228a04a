// The packets of events as the wire has them: what they take, and what the other end is told by them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "afferent/io/wire/packet_layout.hpp"
#include "bench/link_activity.hpp"

namespace afferent {

// The longest silence on the link, where packets are not rarer still.
inline constexpr Duration link_heartbeat = 25ms;

// Rice codes; with a tolerance, predicted within it (0: to the tick).
PacketLayout event_layout(const LinkActivity& activity, Duration tick, Duration deadline,
                          std::optional<Duration> tolerance = {});

// With framing and heartbeats. Throws ParameterError, as layout.check().
std::uint64_t event_bytes(const LinkActivity& activity, const PacketLayout& layout);

// What one packet says of the spans that it covers. Where spikes are predicted, spans that came as foreseen
// are told by the next packet, or by the heartbeat.
struct ToldSpan {
    TimePoint begin;
    TimePoint end;
    TimePoint closes;  // when the packet is sent
    std::vector<Event> events;
};
std::vector<ToldSpan> told_spans(const LinkActivity& activity, const PacketLayout& layout);

}  // namespace afferent
