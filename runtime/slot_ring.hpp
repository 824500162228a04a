// A bounded queue from one thread to another that never waits and, once its slots have grown to what they
// hold, never allocates.
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

namespace afferent {

// One thread fills, one takes. Slots are filled and read in place, so that what they have allocated is used
// again.
//
//     if (Slot* slot = ring.free_slot()) { slot->...; ring.push(); } else ++dropped;
//     while (Slot* slot = ring.next()) { ...; ring.pop(); }
template <class Slot>
class SlotRing {
  public:
    explicit SlotRing(std::size_t slots) : slots_(slots) {}
    // Each begins as this one.
    SlotRing(std::size_t slots, const Slot& first) : slots_(slots, first) {}

    // For the thread that fills. Null where there is no room; the slot holds what was left in it.
    Slot* free_slot() noexcept { return room() > 0 ? &slots_[filled_.load(own) % slots_.size()] : nullptr; }
    void push() noexcept { filled_.store(filled_.load(own) + 1, std::memory_order_release); }
    std::size_t room() const noexcept {
        return slots_.size() - (filled_.load(own) - taken_.load(std::memory_order_acquire));
    }

    // For the thread that takes. Null where there is nothing.
    Slot* next() noexcept {
        const std::size_t taken = taken_.load(own);
        return taken == filled_.load(std::memory_order_acquire) ? nullptr : &slots_[taken % slots_.size()];
    }
    void pop() noexcept { taken_.store(taken_.load(own) + 1, std::memory_order_release); }

    // For either.
    std::size_t waiting() const noexcept {
        const std::size_t taken = taken_.load(std::memory_order_acquire);
        return filled_.load(std::memory_order_acquire) - taken;
    }

  private:
    // Each count is written by one thread, which may read it as it likes.
    static constexpr std::memory_order own = std::memory_order_relaxed;
    static constexpr std::size_t cache_line = 64;

    std::vector<Slot> slots_;
    alignas(cache_line) std::atomic<std::size_t> filled_{0};
    alignas(cache_line) std::atomic<std::size_t> taken_{0};
};

}  // namespace afferent
