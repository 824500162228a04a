// Events in NWB's table of units.
#pragma once

#include <chrono>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/result.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// What NWB asks to be told of a session.
struct NwbSession {
    std::string description = "Address events";
    // When the events' time was zero. A scene does not know it.
    std::chrono::system_clock::time_point start;
    std::chrono::system_clock::time_point created;
};

// Sorted events. `not_allowed` beyond longest_in_hdf5, `closed` where the file cannot be written.
Result<void> write_nwb(const std::filesystem::path& file, std::span<const Event> events,
                       const NwbSession& session);

// Sorted by time and address, to the nearest nanosecond; the id of a unit is its address. `malformed` names
// what is wrong and where.
Result<std::vector<Event>> read_nwb(const std::filesystem::path& file);

}  // namespace afferent
