// Events of a window as single numbers, which sort as the events do and take half their memory.
#pragma once

#include <cassert>
#include <cstdint>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// The nanoseconds since the window's base, then the address.
using EventKey = std::uint64_t;

class EventKeys {
  public:
    static constexpr int address_bits = 24;
    // Events lie before base + longest.
    static constexpr Duration longest{Duration::rep{1} << (63 - address_bits)};

    void begin(TimePoint base) noexcept {
        base_ = base;
        keys_.clear();
    }

    // The time is not before the base, and the address below 2^24.
    void add(TimePoint time, Address address) {
        assert(time >= base_ && time - base_ < longest && address >> address_bits == 0);
        keys_.push_back(static_cast<EventKey>((time - base_).count()) << address_bits | address);
    }

    TimePoint base() const noexcept { return base_; }
    std::vector<EventKey>& keys() noexcept { return keys_; }
    const std::vector<EventKey>& keys() const noexcept { return keys_; }

    static Event event(TimePoint base, EventKey key) noexcept {
        return {base + Duration(static_cast<Duration::rep>(key >> address_bits)),
                static_cast<Address>(key & ((EventKey{1} << address_bits) - 1))};
    }

  private:
    TimePoint base_ = scene_start;
    std::vector<EventKey> keys_;
};

}  // namespace afferent
