// The input of the runtime: the forces of neighbouring elements at one time.
#pragma once

#include <span>

#include "afferent/runtime/event.hpp"

namespace afferent {

// Samples of the elements first, first + 1, ..., taken at the same time. A clocked sensor gives one scan for
// a whole patch, an asynchronous one a scan with a single sample. Each force is held until the next.
struct Scan {
    TimePoint time;
    Address first;
    std::span<const double> forces_n;
};

}  // namespace afferent
