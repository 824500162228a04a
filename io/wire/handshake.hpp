// What the two ends of a session have to agree on before the first packet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "afferent/io/wire/messages.hpp"
#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

// The version of the wire, which is not that of the library. It changes when an older peer would misread a
// message.
inline constexpr std::uint32_t wire_version = 3;

// Fills in the layout's part of a hello, and the version.
void describe(const PacketLayout& layout, proto::Hello& hello);

// The layout that a hello describes. `malformed` if it is not a valid layout, or if the thresholds do not fit
// the heartbeat: freeze_ms must be at least twice heartbeat_ms, and safe_ms more than freeze_ms.
Result<PacketLayout> layout_of(const proto::Hello& hello);

// Why these two cannot have a session, as a message to a person: "the scenes differ in link.packet_ms; from
// ours to theirs: modified: packet_ms: 5 -> 10". Nothing but the nonce may differ. It holds no fingerprint.
std::optional<std::string> disagreement(const proto::Hello& theirs, const proto::Hello& ours);

}  // namespace afferent
