#include "afferent/nodes/ranks/sorted_runs.hpp"

#include <algorithm>

namespace afferent::ranks {

void SortedRuns::clear() {
    events_.clear();
    ends_.clear();
}

void SortedRuns::add(std::span<const Event> sorted) {
    events_.insert(events_.end(), sorted.begin(), sorted.end());
    ends_.push_back(events_.size());
}

std::span<const Event> SortedRuns::merged() {
    while (ends_.size() > 1) merge_neighbours();
    return events_;
}

// Merges each run with the next.
void SortedRuns::merge_neighbours() {
    half_merged_.resize(events_.size());
    const auto at = [](std::vector<Event>& events, std::size_t i) {
        return events.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::size_t begin = 0;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < ends_.size(); i += 2) {
        const std::size_t end = ends_[std::min(i + 1, ends_.size() - 1)];
        std::merge(at(events_, begin), at(events_, ends_[i]), at(events_, ends_[i]), at(events_, end),
                   at(half_merged_, begin));
        ends_[kept++] = begin = end;
    }
    ends_.resize(kept);
    events_.swap(half_merged_);
}

}  // namespace afferent::ranks
