// Which afferents a decoder listens to, in the order of their last spikes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace afferent {

// The others are rejected, because their spikes contradict most afferents time and again, or silent at forces
// at which they would fire. Every change costs O(1).
class AfferentRoster {
  public:
    enum class Standing : std::uint8_t {
        heard,
        unheard,   // silent since the contact began, as is its whole patch: unloaded or dead
        dead,      // silent though its patch fires, or though it fired before
        rejected,  // its spikes contradict those of others
        unlisted,  // never in the roster
    };
    struct Entry {
        std::uint32_t before, after;
        Standing standing;
        std::uint8_t silences;        // in a row, at forces at which it would have fired
        std::uint8_t contradictions;  // how much its spikes have contradicted the others
        bool saturated;               // its last spike was that of an element at full scale
        float last_n;                 // what its last spike measured
        friend bool operator==(const Entry&, const Entry&) = default;
    };
    using Snapshot = std::vector<Entry>;

    static constexpr std::uint32_t end = std::numeric_limits<std::uint32_t>::max();

    explicit AfferentRoster(std::size_t afferents) : entries_(afferents + 1) { clear(); }

    void clear() noexcept {
        const auto head = static_cast<std::uint32_t>(entries_.size() - 1);
        for (Entry& entry : entries_) entry = {end, end, Standing::unlisted, 0, 0, false, 0};
        entries_[head].before = entries_[head].after = head;
        listed_ = 0;
    }
    // Adds it as the afferent that fired last.
    void append(std::uint32_t index) noexcept {
        remove(index, Standing::heard);
        link(index, entries_[head()].before, head());
    }
    // Adds it as the afferent that has been silent for longest.
    void prepend(std::uint32_t index) noexcept {
        remove(index, Standing::heard);
        link(index, head(), entries_[head()].after);
    }
    void remove(std::uint32_t index, Standing standing) noexcept {
        Entry& entry = entries_[index];
        entry.standing = standing;
        if (entry.after == end) return;
        entries_[entry.before].after = entry.after;
        entries_[entry.after].before = entry.before;
        entry.before = entry.after = end;
        --listed_;
    }

    Entry& operator[](std::uint32_t index) noexcept { return entries_[index]; }
    const Entry& operator[](std::uint32_t index) const noexcept { return entries_[index]; }
    std::uint32_t listed() const noexcept { return listed_; }
    std::uint32_t size() const noexcept { return head(); }

    // The afferent that has been silent for longest, and the next; `end` after the last.
    std::uint32_t first() const noexcept { return or_end(entries_[head()].after); }
    std::uint32_t next(std::uint32_t index) const noexcept { return or_end(entries_[index].after); }
    // The afferent that fired last, and the one before; `end` before the first.
    std::uint32_t last() const noexcept { return or_end(entries_[head()].before); }
    std::uint32_t previous(std::uint32_t index) const noexcept { return or_end(entries_[index].before); }

    const Snapshot& snapshot() const noexcept { return entries_; }
    void resume(const Snapshot& snapshot) noexcept {
        entries_ = snapshot;
        listed_ = 0;
        for (std::uint32_t index = first(); index != end; index = next(index)) ++listed_;
    }
    std::size_t heap_bytes() const noexcept { return entries_.capacity() * sizeof(Entry); }

  private:
    std::uint32_t head() const noexcept { return static_cast<std::uint32_t>(entries_.size() - 1); }
    std::uint32_t or_end(std::uint32_t index) const noexcept { return index == head() ? end : index; }
    void link(std::uint32_t index, std::uint32_t before, std::uint32_t after) noexcept {
        entries_[index].before = before;
        entries_[index].after = after;
        entries_[before].after = entries_[after].before = index;
        ++listed_;
    }

    std::vector<Entry> entries_;  // the last is the list's head and tail
    std::uint32_t listed_ = 0;
};

}  // namespace afferent
