// Where a scene's neurons are spread over several processes: what passes between them.
#pragma once

#include <span>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/result.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent {

// Each process computes the shards of its own plan. A coprocessor's end calls this once for each window, and
// for each scan; without it, all neurons are in this process.
class EventExchange {
  public:
    virtual ~EventExchange() = default;

    // A scan that this process's neurons are given.
    virtual void push(const Scan& scan) = 0;
    // They are about to compute the window up to and including `until`, with all scans up to then.
    virtual void begin(TimePoint until) = 0;
    // They have, and these are their events. Returns those of the scene that this process is to send and to
    // decode, sorted, valid until the next call.
    virtual Result<std::span<const Event>> exchange(TimePoint until, std::span<const Event> own) = 0;
};

}  // namespace afferent
