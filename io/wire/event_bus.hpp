// An address-event bus on a chip: many rows of neurons, one arbiter, one event a cycle.
#pragma once

#include <boost/dynamic_bitset.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"

namespace afferent {

struct EventBusParameters {
    Address addresses = 1;
    Duration cycle = 100ns;
    std::uint32_t rows = 1;         // each has an equal run of addresses
    std::uint32_t row_events = 16;  // how many events may wait in a row; more are dropped

    // Throws ParameterError, with the names of the scene's bus.
    void check() const;
};

struct EventBusCounts {
    std::uint64_t events = 0;      // events that left the bus
    std::uint64_t collisions = 0;  // events that found the bus busy
    std::uint64_t dropped = 0;
};

// An event that finds the bus free leaves it one cycle later. Others wait in their row; the arbiter serves
// the rows that have events in turn, and each row in order. (Boahen, IEEE TCAS-II 47, 2000, gives the
// arithmetic of such a bus.)
class EventBus {
  public:
    // Throws ParameterError.
    explicit EventBus(const EventBusParameters& parameters);

    // Sorted by time, and not before events pushed earlier. Appends what leaves the bus before `until`, with
    // the time at which it does, sorted.
    void pass(std::span<const Event> events, TimePoint until, std::vector<Event>& out);

    bool empty() const noexcept { return waiting_rows_.none() && !in_service_; }
    const EventBusCounts& counts() const noexcept { return counts_; }

    // The delay that this share of all events did not exceed, with the resolution of a cycle: 0.5 gives the
    // median, 1 the longest delay.
    Duration delay(double share) const;

  private:
    struct Waiting {
        TimePoint since;
        Address address;
    };
    // A row's part of waiting_, used as a ring.
    struct Row {
        std::uint32_t first = 0;
        std::uint32_t count = 0;
    };

    void serve_until(TimePoint time, std::vector<Event>& out);
    void take(const Event& event);
    void leave(std::vector<Event>& out);

    EventBusParameters parameters_;
    std::uint32_t addresses_per_row_;
    std::vector<Row> rows_;
    std::vector<Waiting> waiting_;  // row by row
    boost::dynamic_bitset<> waiting_rows_;
    std::size_t turn_ = 0;               // the row that is served next, if it has an event
    TimePoint free_at_ = scene_start;    // when the current cycle ends
    std::optional<Event> in_service_;    // leaves at the end of the current cycle, with that time
    std::size_t delay_in_service_ = 0;   // in whole cycles
    std::vector<std::uint64_t> delays_;  // events by whole cycles of delay
    EventBusCounts counts_;
};

}  // namespace afferent
