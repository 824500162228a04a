// Merges the sorted events of several ranks.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent::ranks {

// An event costs O(log n) comparisons with n runs. Memory is kept for the next window.
class SortedRuns {
  public:
    void clear();
    void add(std::span<const Event> sorted);
    // Merges all runs that were added since clear(). Valid until the next call of add() or clear().
    std::span<const Event> merged();

  private:
    void merge_neighbours();

    std::vector<Event> events_;  // one run after the other
    std::vector<Event> half_merged_;
    std::vector<std::size_t> ends_;  // of the runs in events_
};

}  // namespace afferent::ranks
