// Counts what a whole program of tests allocates. One of its sources includes this: it replaces operator new.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace afferent {

inline std::atomic<std::uint64_t> allocations{0};
inline std::atomic<std::uint64_t> allocated_bytes{0};

inline void* counted(std::size_t size) {
    ++allocations;
    allocated_bytes += size;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}

}  // namespace afferent

// Where one of a pair is inlined and the other is not, the compiler takes them for mismatched.
#define AFFERENT_NOT_INLINED __attribute__((noinline))
AFFERENT_NOT_INLINED void* operator new(std::size_t size) { return afferent::counted(size); }
AFFERENT_NOT_INLINED void* operator new[](std::size_t size) { return afferent::counted(size); }
AFFERENT_NOT_INLINED void operator delete(void* memory) noexcept { std::free(memory); }
AFFERENT_NOT_INLINED void operator delete[](void* memory) noexcept { std::free(memory); }
AFFERENT_NOT_INLINED void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
AFFERENT_NOT_INLINED void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
#undef AFFERENT_NOT_INLINED
