// How often the afferents fired in a sliding window, and how much of that window is known.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/decoders/ring_buffer.hpp"
#include "afferent/decoders/silence.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// Counts the events of the window (now − length, now]. Silence is a measurement: a span is known if a packet
// has covered it, with events or without, and also if its packet would have arrived by now had there been any
// events in it. (Leaving such a span out until its packet arrives would leave out only silent ones, and
// overestimate.) A span that was lost, or whose packet cannot have arrived yet, is unknown: its time is
// excluded from the time that the counts are divided by.
//
// Allocates nothing after construction while the window holds at most 500 events per second and address (at
// least 1024) and 64 unknown spans; a busier window doubles its room and keeps it.
class SpikeRate {
  public:
    // read[address]: whether its events are counted. Throws ParameterError: window > 0.
    SpikeRate(std::vector<bool> read, Duration window);
    SpikeRate(std::size_t addresses, Duration window)
        : SpikeRate(std::vector<bool>(addresses, true), window) {}

    // [begin, end) is known, and these are its events, sorted. Spans come in the order of time; the time
    // between this one and the one before is lost.
    void observe(TimePoint begin, TimePoint end, std::span<const Event> events);
    // Events before `until` would have arrived by now: a span up to there that has been neither observed nor
    // lost counts as silent.
    void presume_silence(TimePoint until) noexcept { presumed_until_ = std::max(presumed_until_, until); }
    // Nothing will ever be known of [begin, end).
    void lose(TimePoint begin, TimePoint end);
    // Moves the window; times do not decrease.
    void advance(TimePoint now);
    // As after construction, but nothing before `start` is known.
    void reset(TimePoint start) { resume(start, start); }
    // The same, but the last span before `start` ended at `heard_until`.
    void resume(TimePoint start, TimePoint heard_until);

    std::size_t events() const noexcept { return events_.size(); }
    std::uint32_t events_of(Address address) const noexcept { return counts_[address]; }
    std::size_t addresses() const noexcept { return counts_.size(); }
    // The part of the window that is known; 0 to its length.
    Duration known() const noexcept;
    // The end of the last span that was observed or lost.
    TimePoint heard_until() const noexcept { return heard_until_; }
    Duration window() const noexcept { return window_; }

    // As SpikeCounts (grip_estimator.hpp).
    double known_s() const noexcept { return seconds(known()); }
    double window_s() const noexcept { return known_s(); }
    double short_hz(double) const noexcept { return 1 / known_s(); }
    double spike_hz() const noexcept { return 2 * known() < window_ ? 1 / known_s() : 0; }
    double allowed_hz() const noexcept { return allowed_since(last_); }
    double allowed_hz_of(Address address) const noexcept { return allowed_since(last_of_[address]); }

    struct Span {
        TimePoint begin, end;
        friend bool operator==(const Span&, const Span&) = default;
    };
    struct Snapshot {
        TimePoint now, start, heard_until, presumed_until;
        std::vector<Event> events;  // in the window
        std::vector<Span> unknown;
        TimePoint lost_until;
        std::vector<TimePoint> last_of;  // spike, by address
        friend bool operator==(const Snapshot&, const Snapshot&) = default;
    };
    Snapshot snapshot() const;
    // Throws ParameterError, and changes nothing, if it is of another number of addresses or an event is of
    // one that is not read.
    void resume(const Snapshot& snapshot);

    // Its memory on the heap.
    std::size_t heap_bytes() const noexcept;

  private:
    TimePoint known_until() const noexcept { return std::min(now_, std::max(heard_until_, presumed_until_)); }
    double allowed_since(TimePoint last) const noexcept {
        return afferent::allowed_hz(last, lost_until_, known_until(), window_);
    }

    std::vector<bool> read_;
    Duration window_;
    TimePoint now_ = scene_start;
    TimePoint start_ = scene_start;
    TimePoint heard_until_ = scene_start;
    TimePoint presumed_until_ = scene_start;
    RingBuffer<Event> events_;
    RingBuffer<Span> unknown_;
    std::vector<std::uint32_t> counts_;
    TimePoint lost_until_ = scene_start;
    TimePoint last_ = never_fired;    // spike of any address
    std::vector<TimePoint> last_of_;  // and of each
};

}  // namespace afferent
