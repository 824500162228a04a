// What the messages of a window hold. All ranks run on machines of one kind: numbers are sent as they are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "afferent/nodes/ranks/post.hpp"
#include "afferent/runtime/event.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent::ranks {

// Events of the window after `from` up to and including `until`, in eight bytes each: a window is shorter
// than four seconds.
void put_events(Bytes& bytes, TimePoint from, TimePoint until, std::span<const Event> events);
// Appends them, and returns `until`.
TimePoint take_events(const Bytes& bytes, std::vector<Event>& events);

// The scans of a window, added one by one, and then its end.
void put_scan(Bytes& bytes, const Scan& scan);
void put_end(Bytes& bytes, TimePoint until);
// Calls use(scan) for each, in their order, and returns the window's end. The forces of the scan that is
// given to `use` lie in `forces_n`.
TimePoint take_scans(const Bytes& bytes, std::vector<double>& forces_n,
                     const std::function<void(const Scan&)>& use);

// What a rank has done, at its end.
struct Report {
    std::uint64_t windows = 0;
    std::uint64_t events = 0;
    std::uint64_t bytes = 0;  // of messages with events
    // That no rank before it has counted.
    std::uint64_t samples = 0;
    std::uint64_t clipped = 0;
    double compute_s = 0;  // processor time in its neurons
    double rest_s = 0;     // processor time for everything else but waiting
    double wait_s = 0;     // for other ranks, by the clock
    double run_s = 0;      // all of it, by the clock

    friend bool operator==(const Report&, const Report&) = default;
};

void put_report(Bytes& bytes, const Report& report);
Report take_report(const Bytes& bytes);

}  // namespace afferent::ranks
