// What both ends of a session have to know to read its packets.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "afferent/io/wire/neuron_law.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

enum class Encoding : std::uint8_t { rice, fixed_width, predicted };

// Neurons of one law; their addresses follow those of the group before.
struct NeuronGroup {
    Address addresses = 0;
    NeuronLaw law;

    friend bool operator==(const NeuronGroup&, const NeuronGroup&) = default;
};

// The defaults are those of a scene's link.
struct PacketLayout {
    Address addresses = 1;
    // The resolution of an event's time: an event is in the tick floor(time / tick), counted from the start
    // of the scene.
    Duration tick = 100us;
    // What a packet covers is a whole number of spans; a span is a multiple of the tick.
    Duration span = 5ms;
    // Packets with events close at each multiple of so many spans, and while a touch begins at each span. A
    // touch begins with the first event after a heartbeat without any, for a heartbeat.
    std::uint32_t gathered_spans = 1;
    // The longest stretch of silence that one packet reports, rounded up to whole spans.
    Duration heartbeat = 25ms;
    Encoding encoding = Encoding::rice;
    // The most events of one packet; more go into further parts of it.
    std::uint32_t max_events = 4096;
    // The rest counts for Encoding::predicted alone. A spike that comes within this of its foreseen tick is
    // told to have come in that.
    Duration tolerance{};
    // Packets may be lost: what they tell refers to what the other end has acknowledged, and not to the
    // packet before.
    bool acknowledged = false;
    // Of all addresses, in their order.
    std::vector<NeuronGroup> neurons = {};

    // Throws ParameterError, with the names of the scene's link: addresses > 0, tick_us > 0, packet_ms a
    // multiple of the tick and at most 4 s, gathered_spans > 0, heartbeat_ms >= packet_ms and at most 8000
    // spans, packet_events from 1 to 50,000, at most 2^32 codes. Where spikes are predicted, besides: no
    // prompt_ms, packet_ms at most 65,536 ticks, timing_tolerance_us a multiple of tick_us, >= 0 and below
    // half of packet_ms.
    void check() const;

    // How many codes there are in one span: ticks · addresses.
    std::uint64_t span_codes() const noexcept { return static_cast<std::uint64_t>(span / tick) * addresses; }
    // The most codes that there are in one packet.
    std::uint64_t codes() const noexcept { return gathered_spans * span_codes(); }
    // The events of a packet lie in the last of its spans: in so many of them.
    std::uint32_t spans_with_events(std::uint32_t spans) const noexcept {
        return std::min(spans, gathered_spans);
    }
    std::uint32_t heartbeat_spans() const noexcept {
        return static_cast<std::uint32_t>((heartbeat + span - Duration(1)) / span);
    }

    friend bool operator==(const PacketLayout&, const PacketLayout&) = default;
};

// Positions are sent modulo this: two bytes. A packet that is more than half of it ahead is taken for an old
// one, so that silence up to 8191 spans (41 s of 5 ms) is told from the past; sessions end long before that.
inline constexpr std::uint32_t position_modulus = 16'383;

// Running counts are sent modulo these.
inline constexpr std::uint64_t count_modulus = std::uint64_t{1} << 28;
inline constexpr std::uint64_t silent_count_modulus = std::uint64_t{1} << 21;

// So are the checks of what is foreseen.
inline constexpr std::uint32_t check_modulus = std::uint32_t{1} << 14;

}  // namespace afferent
