// Events in NWB's table of units.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "afferent/io/files/event_set.hpp"

namespace afferent {

// What NWB requires to know of a session.
struct NwbSession {
    std::string description = "Address events";
    // The date of the events' time zero. A scene does not know it.
    std::chrono::system_clock::time_point start;
    std::chrono::system_clock::time_point created;
};

// A unit for each afferent of the patches, silent or not; where there are none, for each that fired.
// `not_allowed` beyond longest_in_hdf5, `closed` where the file cannot be written.
Result<void> write_nwb(const std::filesystem::path& file, const EventSet& set, const NwbSession& session);

// To the nearest nanosecond; the id of a unit is its address. Patches where the units count from 0 and have a
// column `patch`. `malformed` names what is wrong and where.
Result<EventSet> read_nwb(const std::filesystem::path& file);

}  // namespace afferent
