// An address event: which afferent fired, and when. Included by programs that take or pass events.
#pragma once

#include <compare>
#include <cstdint>

#include "afferent/runtime/time.hpp"

namespace afferent {

using Address = std::uint32_t;

// Ordered by time, then by address.
struct Event {
    TimePoint time;
    Address address;

    friend auto operator<=>(const Event&, const Event&) = default;
};

}  // namespace afferent
