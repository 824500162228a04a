#include "afferent/io/wire/checksum.hpp"

#include <isa-l/crc.h>

#include <cassert>
#include <limits>

namespace afferent {
namespace {

#ifdef __x86_64__
// After a long frame, ISA-L leaves values in the upper parts of the vector registers. Each SSE instruction of
// the thread would then wait for them: exp() takes thirty times as long.
__attribute__((target("avx"))) void clear_upper_parts() noexcept { __builtin_ia32_vzeroupper(); }
#endif

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept {
    assert(bytes.size() <= std::numeric_limits<int>::max());
    // The library only reads, though it asks for a pointer to non-const.
    auto* data = const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(bytes.data()));
    const std::uint32_t sum = ~crc32_iscsi(data, static_cast<int>(bytes.size()), 0xffffffffU);
#ifdef __x86_64__
    static const bool has_upper_parts = __builtin_cpu_supports("avx");
    if (has_upper_parts) clear_upper_parts();
#endif
    return sum;
}

}  // namespace afferent
