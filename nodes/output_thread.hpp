// On which thread of a hand an output runs, and what it may lose there.
#pragma once

#include <cstdint>

namespace afferent {

enum class OutputThread {
    // That which runs the link: for what acts on the world as soon as something is known. A call must not
    // wait, and
    // costs some microseconds; what it cannot pass on is lost and counted.
    link,
    // That which writes, behind a queue: for what keeps a record. A call may wait for a disk; when the queue
    // is full,
    // steps are lost and counted (GripReport::lost_steps).
    writer,
};

// What an output has not taken, because it could not keep up.
struct OutputLosses {
    std::uint64_t steps = 0;
    std::uint64_t events = 0;
};

}  // namespace afferent
