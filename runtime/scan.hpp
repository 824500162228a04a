// A scan: the forces of neighbouring elements at one time. Included by programs that push samples.
#pragma once

#include <span>

#include "afferent/runtime/event.hpp"

namespace afferent {

// Samples of the elements first, first + 1, ..., taken at the same time. A clocked sensor gives one scan for
// a whole patch, an asynchronous one a scan of a single sample. Each force is held until the element's next
// sample.
struct Scan {
    TimePoint time;
    Address first;
    std::span<const double> forces_n;
};

}  // namespace afferent
