// Events, and what is known of the neurons that might have fired.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/population.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

struct EventSet {
    std::vector<Event> events;          // sorted by time and address
    Population population = {};         // who might have fired
    Duration resolution = Duration(1);  // the smallest difference between two times
    bool operator==(const EventSet&) const = default;
};

// `malformed` if an event belongs to none of the patches, if events are not sorted or lie before the start,
// or if afferents are told of, and not each of them.
Result<void> check(const EventSet& set);

// For a pipe between two programs of one build.
std::vector<std::byte> to_bytes(const EventSet& set);
// Checked: the bytes may come from a program that has read a hostile file.
Result<EventSet> event_set(std::span<const std::byte> bytes);

}  // namespace afferent
