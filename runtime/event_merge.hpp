// Merges sorted streams of events into one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/event_key.hpp"

namespace afferent {

// An event costs O(log n) comparisons with n streams that have events, and a stream without events costs one
// look. The heap is allocated by the constructor.
class EventMerge {
  public:
    explicit EventMerge(std::size_t streams) : streams_(streams) { cursors_.reserve(streams); }

    // Calls sink(key) for the keys of stream(0), stream(1), ..., each a sorted std::span<const EventKey>, in
    // their order.
    template <class Stream, class Sink>
    void operator()(Stream&& stream, Sink&& sink) {
        cursors_.clear();
        for (std::size_t i = 0; i < streams_; ++i) {
            const std::span<const EventKey> keys = stream(i);
            if (!keys.empty()) cursors_.push_back({keys.front(), keys.data(), keys.data() + keys.size()});
        }
        for (std::size_t at = cursors_.size() / 2; at-- > 0;) lower(at, cursors_[at]);
        while (cursors_.size() > 1) {
            Cursor& first = cursors_.front();
            sink(first.key);
            if (++first.at != first.end) {
                first.key = *first.at;
                lower(0, Cursor(first));
            } else {
                const Cursor last = cursors_.back();
                cursors_.pop_back();
                lower(0, last);
            }
        }
        if (cursors_.empty()) return;
        for (const EventKey* at = cursors_.front().at; at != cursors_.front().end; ++at) sink(*at);
    }

  private:
    struct Cursor {
        EventKey key;  // *at, kept here for the comparisons
        const EventKey* at;
        const EventKey* end;
    };

    // Puts the cursor at that slot of the heap, or below it.
    void lower(std::size_t at, const Cursor cursor) noexcept {
        const std::size_t size = cursors_.size();
        for (std::size_t child = 2 * at + 1; child < size; child = 2 * at + 1) {
            if (child + 1 < size && cursors_[child + 1].key < cursors_[child].key) ++child;
            if (!(cursors_[child].key < cursor.key)) break;
            cursors_[at] = cursors_[child];
            at = child;
        }
        cursors_[at] = cursor;
    }

    std::size_t streams_;
    std::vector<Cursor> cursors_;  // a binary heap; the first is the earliest
};

}  // namespace afferent
