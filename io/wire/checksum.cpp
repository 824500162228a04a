#include "afferent/io/wire/checksum.hpp"

#include <isa-l/crc.h>

#include <cassert>
#include <limits>

namespace afferent {

std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept {
    assert(bytes.size() <= std::numeric_limits<int>::max());
    // The library only reads, though it asks for a pointer to non-const.
    auto* data = const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(bytes.data()));
    return ~crc32_iscsi(data, static_cast<int>(bytes.size()), 0xffffffffU);
}

}  // namespace afferent
