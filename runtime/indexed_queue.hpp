// The queue of predicted spikes: at most one entry per neuron, moved and never duplicated.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "afferent/runtime/time.hpp"

namespace afferent {

// A four-ary heap with the position of every index. Earliest first, equal times by index. Only the
// constructor allocates.
class IndexedQueue {
  public:
    using Index = std::uint32_t;
    struct Entry {
        TimePoint time;
        Index index;
        friend auto operator<=>(const Entry&, const Entry&) = default;
    };

    explicit IndexedQueue(std::size_t indices) : position_(indices, absent) { heap_.reserve(indices); }

    bool empty() const noexcept { return heap_.empty(); }
    std::size_t size() const noexcept { return heap_.size(); }
    bool contains(Index index) const noexcept { return position_[index] != absent; }
    const Entry& next() const noexcept {
        assert(!empty());
        return heap_.front();
    }

    // Enters the index, or moves its entry.
    void schedule(Index index, TimePoint time) noexcept {
        std::uint32_t at = position_[index];
        const Entry entry{time, index};
        if (at == absent) {
            at = static_cast<std::uint32_t>(heap_.size());
            heap_.push_back(entry);  // never grows: reserved for every index
            rise(at, entry);
        } else if (entry < heap_[at]) {
            rise(at, entry);
        } else {
            sink(at, entry);
        }
    }

    // Removes the index if it has an entry.
    void remove(Index index) noexcept {
        const std::uint32_t at = position_[index];
        if (at == absent) return;
        position_[index] = absent;
        const Entry last = heap_.back();
        heap_.pop_back();
        if (last.index == index) return;
        if (at > 0 && last < heap_[parent(at)])
            rise(at, last);
        else
            sink(at, last);
    }

    void clear() noexcept {
        for (const Entry& entry : heap_) position_[entry.index] = absent;
        heap_.clear();
    }

  private:
    static constexpr std::uint32_t absent = std::numeric_limits<std::uint32_t>::max();
    static constexpr std::uint32_t arity = 4;
    static std::uint32_t parent(std::uint32_t at) noexcept { return (at - 1) / arity; }

    void put(std::uint32_t at, const Entry& entry) noexcept {
        heap_[at] = entry;
        position_[entry.index] = at;
    }

    void rise(std::uint32_t at, const Entry& entry) noexcept {
        while (at > 0 && entry < heap_[parent(at)]) {
            put(at, heap_[parent(at)]);
            at = parent(at);
        }
        put(at, entry);
    }

    void sink(std::uint32_t at, const Entry& entry) noexcept {
        const auto size = static_cast<std::uint32_t>(heap_.size());
        for (;;) {
            const std::uint32_t first = at * arity + 1;
            if (first >= size) break;
            std::uint32_t least = first;
            for (std::uint32_t child = first + 1; child < size && child < first + arity; ++child)
                if (heap_[child] < heap_[least]) least = child;
            if (!(heap_[least] < entry)) break;
            put(at, heap_[least]);
            at = least;
        }
        put(at, entry);
    }

    std::vector<Entry> heap_;
    std::vector<std::uint32_t> position_;
};

}  // namespace afferent
