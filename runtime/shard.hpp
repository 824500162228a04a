// A range of neurons that one thread advances through a window, independently of all others.
#pragma once

#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent {

class Shard {
  public:
    virtual ~Shard() = default;

    // Computes the window that ends at `until`.
    //
    // Scans are applied at their own times, which do not decrease and lie between the previous `until` and
    // this one, both included; samples for other shards are skipped. At equal times a due spike fires before
    // the drive changes. Appends every spike with a stamp up to and including `until`, sorted.
    virtual void advance(TimePoint until, std::span<const Scan> scans, std::vector<Event>& events) = 0;

    // Back to the state after construction.
    virtual void reset() = 0;

    virtual std::size_t bytes() const noexcept = 0;
};

}  // namespace afferent
