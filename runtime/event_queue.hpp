// The event queue of a scene: everything that is not a neuron, in one total order.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <functional>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// What can be due. The order of the names is the order at equal times: a packet closes with the spikes that
// came before its deadline, what arrives is decoded before the controller steps, the step moves the hand
// up to its own time, and a scan samples the hand where the step has left it.
enum class Kind : std::uint8_t { packet_deadline, arrival, step, scan };

struct Due {
    TimePoint time;
    Kind kind;
    Address address;  // of the patch, link or electrode that it is for; breaks ties of equal time and kind

    friend auto operator<=>(const Due&, const Due&) = default;
};

class EventQueue {
  public:
    // Allocates room for that many entries; beyond it, schedule() allocates.
    explicit EventQueue(std::size_t capacity) { heap_.reserve(capacity); }

    void reserve(std::size_t capacity) { heap_.reserve(capacity); }

    bool empty() const noexcept { return heap_.empty(); }
    const Due& next() const noexcept { return heap_.front(); }

    void schedule(Due due) {
        heap_.push_back(due);
        std::push_heap(heap_.begin(), heap_.end(), std::greater<>());
    }

    Due pop() noexcept {
        std::pop_heap(heap_.begin(), heap_.end(), std::greater<>());
        const Due due = heap_.back();
        heap_.pop_back();
        return due;
    }

    // Takes out all that are of this kind.
    void remove(Kind kind) noexcept {
        std::erase_if(heap_, [kind](const Due& due) { return due.kind == kind; });
        std::make_heap(heap_.begin(), heap_.end(), std::greater<>());
    }
    void clear() noexcept { heap_.clear(); }

  private:
    std::vector<Due> heap_;
};

}  // namespace afferent
