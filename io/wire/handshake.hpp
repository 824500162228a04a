// What the two sides of a session have to agree on before the first packet.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "afferent/io/wire/messages.hpp"
#include "afferent/io/wire/packet_layout.hpp"
#include "afferent/io/wire/result.hpp"

namespace afferent {

// Of the wire alone, apart from the library's. It changes when an older peer would misread a message.
inline constexpr std::uint32_t wire_version = 1;

// Fills in the layout's part of a hello, and the version.
void describe(const PacketLayout& layout, proto::Hello& hello);

// The layout that a hello describes; `malformed` where it is none, or where its thresholds do not fit its
// heartbeat: freeze_ms at least twice heartbeat_ms, safe_ms above freeze_ms.
Result<PacketLayout> layout_of(const proto::Hello& hello);

// Why a session between these two cannot be, for a person to read: "scene fingerprint 12ab… is not ours,
// 34cd…". The nonce may differ, all else must be equal.
std::optional<std::string> disagreement(const proto::Hello& theirs, const proto::Hello& ours);

}  // namespace afferent
