// The spikes of each afferent in a window of time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/time.hpp"

namespace afferent {

// Holds at most as many spikes of an afferent as one of fastest_hz fires in the window. Allocates nothing
// after construction.
class SpikeTrains {
  public:
    static constexpr double fastest_hz = 400;

    // The window is shorter than the 4.29 s that 32 bits of nanoseconds hold.
    SpikeTrains(std::size_t afferents, Duration window)
        : window_(window), room_(room_in(window)), counts_(afferents), times_(afferents * room_) {}

    // Spikes of one afferent.
    static std::size_t room_in(Duration window) noexcept {
        return static_cast<std::size_t>(seconds(window) * fastest_hz) + 1;
    }
    Duration window() const noexcept { return window_; }
    std::size_t afferents() const noexcept { return counts_.size(); }

    // At a time from the window's beginning, in nanoseconds. False: there is no room left for the afferent.
    bool add(std::uint32_t afferent, std::uint32_t time_ns) noexcept {
        std::uint32_t& count = counts_[afferent];
        if (count == room_) return false;
        times_[afferent * room_ + count++] = time_ns;
        return true;
    }
    // Parts of a span come in any order.
    void sort() noexcept {
        for (std::size_t i = 0; i < counts_.size(); ++i) {
            std::uint32_t* const first = &times_[i * room_];
            if (!std::is_sorted(first, first + counts_[i])) std::sort(first, first + counts_[i]);
        }
    }
    void clear() noexcept { std::fill(counts_.begin(), counts_.end(), 0); }
    std::span<const std::uint32_t> of(std::size_t afferent) const noexcept {
        return {&times_[afferent * room_], counts_[afferent]};
    }

    std::size_t heap_bytes() const noexcept {
        return (counts_.capacity() + times_.capacity()) * sizeof(std::uint32_t);
    }

  private:
    Duration window_;
    std::size_t room_;  // for each afferent
    std::vector<std::uint32_t> counts_;
    std::vector<std::uint32_t> times_;
};

}  // namespace afferent
