// What both ends of a session have to know to read its packets.
#pragma once

#include <cstdint>

#include "afferent/runtime/event.hpp"

namespace afferent {

enum class Encoding : std::uint8_t { rice, fixed_width };

// The defaults are those of a scene's link.
struct PacketLayout {
    Address addresses = 1;
    // The resolution of an event's time: an event is in the tick floor(time / tick), counted from the start
    // of the scene.
    Duration tick = 100us;
    // A packet closes at each multiple of its span, itself a multiple of the tick.
    Duration span = 5ms;
    // The longest stretch of silence that one packet reports, rounded up to whole spans.
    Duration heartbeat = 25ms;
    Encoding encoding = Encoding::rice;
    // The most events of one packet; more go into further parts of it.
    std::uint32_t max_events = 4096;

    // Throws ParameterError, with the names of the scene's link: addresses > 0, tick_us > 0, packet_ms a
    // multiple of the tick and at most 4 s, heartbeat_ms >= packet_ms and at most 8000 spans, packet_events
    // from 1 to 50,000, at most 2^32 codes.
    void check() const;

    std::uint32_t ticks() const noexcept { return static_cast<std::uint32_t>(span / tick); }
    // How many codes there are in one span: ticks · addresses.
    std::uint64_t codes() const noexcept { return std::uint64_t{ticks()} * addresses; }
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

}  // namespace afferent
