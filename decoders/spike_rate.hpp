// How often the afferents fired in a sliding window, and how much of that window is known.
#pragma once

#include <algorithm>
#include <boost/circular_buffer.hpp>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

// Counts the events of the window (now − length, now]. Silence is a measurement: a span is known when a
// packet has covered it, with or without events, and so is one whose packet would have come by now had there
// been events in it. (To leave such a span out until its packet comes would leave out just the silent ones,
// and overestimate.) What was lost, or cannot have been heard yet, is unknown; it lies in neither the counts
// nor the time that they are divided by.
class SpikeRate {
  public:
    // Events of other addresses than those to read are passed over. Throws ParameterError: window > 0.
    SpikeRate(std::vector<bool> read, Duration window);
    SpikeRate(std::size_t addresses, Duration window)
        : SpikeRate(std::vector<bool>(addresses, true), window) {}

    // The events of the span [begin, end), sorted, in the order of time.
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    // Events before this would have been heard by now: what is not heard is silent, unless it turns out to be
    // lost.
    void presume_silence(TimePoint until) noexcept { presumed_until_ = std::max(presumed_until_, until); }
    // Nothing will be known of [begin, end).
    void lose(TimePoint begin, TimePoint end);
    // Moves the window; times do not decrease.
    void advance(TimePoint now);
    // Back to the beginning: nothing before `start` counts as known.
    void reset(TimePoint start) { resume(start, start); }
    // The same where the last word, of a span that ended at `heard_until`, was heard before `start`.
    void resume(TimePoint start, TimePoint heard_until);

    std::size_t events() const noexcept { return events_.size(); }
    std::uint32_t events_of(Address address) const noexcept { return counts_[address]; }
    std::size_t addresses() const noexcept { return counts_.size(); }
    // The part of the window that is known; 0 to its length.
    Duration known() const noexcept;
    // The end of the last span that was observed or lost.
    TimePoint heard_until() const noexcept { return heard_until_; }
    Duration window() const noexcept { return window_; }

  private:
    struct Span {
        TimePoint begin, end;
    };

    std::vector<bool> read_;
    Duration window_;
    TimePoint now_ = scene_start;
    TimePoint start_ = scene_start;
    TimePoint heard_until_ = scene_start;
    TimePoint presumed_until_ = scene_start;
    boost::circular_buffer<Event> events_;
    boost::circular_buffer<Span> unknown_;
    std::vector<std::uint32_t> counts_;
};

}  // namespace afferent
