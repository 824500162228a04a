// How much memory this process has allocated.
#pragma once

#include <malloc.h>

#include <cstddef>

namespace afferent {

inline std::size_t bytes_in_use() {
    const auto info = ::mallinfo2();
    return info.uordblks + info.hblkhd;
}

}  // namespace afferent
