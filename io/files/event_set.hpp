// Events, and what is known of the neurons that might have fired.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/result.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

struct EventSet {
    struct Patch {
        std::string name;
        std::uint32_t afferents = 0;  // with the addresses that follow those of the patch before
        bool operator==(const Patch&) const = default;
    };

    std::vector<Event> events;          // sorted by time and address
    std::vector<Patch> patches = {};    // from address 0 on; none: not known
    Duration resolution = Duration(1);  // the smallest difference between two times
    bool operator==(const EventSet&) const = default;

    // The number of afferents of all patches.
    std::uint64_t afferents() const noexcept;
};

// `malformed` if an event belongs to none of the patches, or if events are not sorted or lie before the
// start.
Result<void> check(const EventSet& set);

// For a pipe between two programs of one build.
std::vector<std::byte> to_bytes(const EventSet& set);
// Checked: the bytes may come from a program that has read a hostile file.
Result<EventSet> event_set(std::span<const std::byte> bytes);

}  // namespace afferent
