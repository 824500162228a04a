#include "afferent/io/wire/event_bus.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "afferent/runtime/parameter_error.hpp"

namespace afferent {

void EventBusParameters::check() const {
    require(addresses > 0, "addresses", "> 0", addresses);
    require(cycle > Duration::zero(), "cycle_ns", "> 0", static_cast<double>(cycle.count()));
    require(rows > 0 && rows <= addresses, "rows", "from 1 to the number of addresses", rows);
    require(row_events > 0, "row_events", "> 0", row_events);
    require(std::uint64_t{rows} * row_events <= 10'000'000, "row_events", "at most 1e7 on all rows",
            row_events);
}

EventBus::EventBus(const EventBusParameters& parameters) : parameters_(parameters) {
    parameters_.check();
    addresses_per_row_ = (parameters_.addresses + parameters_.rows - 1) / parameters_.rows;
    rows_.resize(parameters_.rows);
    waiting_.resize(std::size_t{parameters_.rows} * parameters_.row_events);
    waiting_rows_.resize(parameters_.rows);
    // The longest delay: every row is full, each event takes a cycle, and a cycle has just begun.
    delays_.resize(waiting_.size() + 2);
}

void EventBus::pass(std::span<const Event> events, TimePoint until, std::vector<Event>& out) {
    for (const Event& event : events) {
        // An event takes part in the arbitration of the cycle that begins at its own time.
        serve_until(event.time - Duration(1), out);
        take(event);
    }
    serve_until(until - Duration(1), out);
    if (in_service_ && in_service_->time < until) leave(out);
}

Duration EventBus::delay(double share) const {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(counts_.events)));
    std::uint64_t so_far = 0;
    for (std::size_t cycles = 0; cycles < delays_.size(); ++cycles) {
        so_far += delays_[cycles];
        if (so_far > 0 && so_far >= wanted) return static_cast<std::int64_t>(cycles) * parameters_.cycle;
    }
    return Duration::zero();
}

// Starts every cycle that begins at or before this time.
void EventBus::serve_until(TimePoint time, std::vector<Event>& out) {
    while (waiting_rows_.any()) {
        std::size_t row = turn_ == 0 ? waiting_rows_.find_first() : waiting_rows_.find_next(turn_ - 1);
        if (row == boost::dynamic_bitset<>::npos) row = waiting_rows_.find_first();
        // If the bus is idle, all waiting events have the same time, and the cycle begins then.
        Row& queue = rows_[row];
        const Waiting& first = waiting_[row * parameters_.row_events + queue.first];
        const TimePoint begin = std::max(free_at_, first.since);
        if (begin > time) return;
        leave(out);
        free_at_ = begin + parameters_.cycle;
        in_service_ = Event{free_at_, first.address};
        // Rounded up to whole cycles.
        const auto delay = (free_at_ - first.since + parameters_.cycle - Duration(1)) / parameters_.cycle;
        delay_in_service_ = static_cast<std::size_t>(delay);
        queue.first = (queue.first + 1) % parameters_.row_events;
        if (--queue.count == 0) waiting_rows_.reset(row);
        turn_ = (row + 1) % rows_.size();
    }
}

void EventBus::leave(std::vector<Event>& out) {
    if (!in_service_) return;
    out.push_back(*in_service_);
    in_service_.reset();
    ++counts_.events;
    ++delays_[delay_in_service_];
}

void EventBus::take(const Event& event) {
    assert(event.address < parameters_.addresses);
    if (event.time < free_at_ || waiting_rows_.any()) ++counts_.collisions;
    const std::size_t row = event.address / addresses_per_row_;
    Row& queue = rows_[row];
    if (queue.count == parameters_.row_events) {
        ++counts_.dropped;
        return;
    }
    const std::uint32_t last = (queue.first + queue.count++) % parameters_.row_events;
    waiting_[row * parameters_.row_events + last] = {event.time, event.address};
    waiting_rows_.set(row);
}

}  // namespace afferent
