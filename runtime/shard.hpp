// A range of neurons that one thread advances through a window, independently of all others.
#pragma once

#include <cstdint>
#include <span>

#include "afferent/runtime/event_key.hpp"
#include "afferent/runtime/scan.hpp"

namespace afferent {

class Shard {
  public:
    virtual ~Shard() = default;

    // Computes the window that ends at `until`.
    //
    // Scans are applied at their own times, which do not decrease and lie between the previous `until` and
    // this one, both included; samples for other shards are skipped. At equal times a due spike fires before
    // the drive changes. Adds every spike with a stamp up to and including `until`, in any order.
    virtual void advance(TimePoint until, std::span<const Scan> scans, EventKeys& events) = 0;

    // Without scans, a window that ends before this time changes nothing and has no spikes. The largest time
    // where only a scan can make a neuron fire.
    virtual TimePoint next() const noexcept = 0;

    // Back to the state after construction.
    virtual void reset() = 0;

    virtual std::size_t bytes() const noexcept = 0;

    // Whether its neurons are swept at each scan, and how often that has changed.
    virtual bool is_dense() const noexcept = 0;
    virtual std::uint64_t form_changes() const noexcept { return 0; }
};

}  // namespace afferent
