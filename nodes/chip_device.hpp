// What a chip sends, as it comes.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "afferent/runtime/monotonic_time.hpp"

namespace afferent {

struct ChipBytes {
    MonotonicTime at{};  // when the last of them came
    std::vector<std::byte> bytes = {};
};

// What it keeps is bounded: when nobody takes it, the newest is dropped, which the reader finds out.
class ChipDevice {
  public:
    virtual ~ChipDevice() = default;
    // The next bytes, valid until the next call; null if there are none.
    virtual const ChipBytes* next() = 0;
    // What people should know of the line.
    virtual std::optional<std::string> next_note() = 0;
};

}  // namespace afferent
