// Merges sorted streams of events into one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// An event costs O(log n) comparisons with n streams that have events, and a stream without events costs one
// look. Equal events come in the order of their streams. The heap is allocated by the constructor; the result
// grows like any vector.
class EventMerge {
  public:
    explicit EventMerge(std::size_t streams) : streams_(streams) { cursors_.reserve(streams); }

    // Replaces `merged` by the events of stream(0), stream(1), ..., each a sorted std::span<const Event>.
    template <class Stream>
    void operator()(Stream&& stream, std::vector<Event>& merged) {
        merged.clear();
        cursors_.clear();
        for (std::size_t i = 0; i < streams_; ++i) {
            const std::span<const Event> events = stream(i);
            if (events.empty()) continue;
            cursors_.push_back({events.front(), static_cast<std::uint32_t>(i), events.data(),
                                events.data() + events.size()});
        }
        for (std::size_t at = cursors_.size() / 2; at-- > 0;) sink(at, cursors_[at]);
        while (cursors_.size() > 1) {
            Cursor& first = cursors_.front();
            merged.push_back(first.event);
            if (++first.at != first.end) {
                first.event = *first.at;
                sink(0, Cursor(first));
            } else {
                const Cursor last = cursors_.back();
                cursors_.pop_back();
                sink(0, last);
            }
        }
        if (!cursors_.empty()) merged.insert(merged.end(), cursors_.front().at, cursors_.front().end);
    }

  private:
    struct Cursor {
        Event event;  // *at, kept here for the comparisons
        std::uint32_t stream;
        const Event* at;
        const Event* end;

        bool before(const Cursor& other) const noexcept {
            const auto order = event <=> other.event;
            return order != 0 ? order < 0 : stream < other.stream;
        }
    };

    // Puts the cursor at that place of the heap, or below it.
    void sink(std::size_t at, const Cursor cursor) noexcept {
        const std::size_t size = cursors_.size();
        for (std::size_t child = 2 * at + 1; child < size; child = 2 * at + 1) {
            if (child + 1 < size && cursors_[child + 1].before(cursors_[child])) ++child;
            if (!cursors_[child].before(cursor)) break;
            cursors_[at] = cursors_[child];
            at = child;
        }
        cursors_[at] = cursor;
    }

    std::size_t streams_;
    std::vector<Cursor> cursors_;  // a binary heap; the first is the earliest
};

}  // namespace afferent
