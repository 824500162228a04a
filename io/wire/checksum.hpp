// CRC-32C, the checksum of every frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace afferent {

// Castagnoli's polynomial, as in iSCSI (RFC 3720, B.4): detects every change of up to three bits in a frame
// of ours.
std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept;

}  // namespace afferent
