// Files of events in HDF5: SONATA's spikes and NWB's units, there and back.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/io/wire/result.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

enum class Hdf5Format {
    // *.sonata.h5: /spikes/afferent with timestamps in ms and node_ids, by time (SONATA developer guide).
    sonata,
    // *.nwb: NWB 2's table /units: id, spike_times in s and where each unit's end.
    nwb,
};

// By the ending; nothing: it is neither.
std::optional<Hdf5Format> hdf5_format_of(const std::filesystem::path& file);

// Times are doubles there, of milliseconds or seconds. Division and multiplication back err by 2^-52 of the
// time together, so below 2^51 ns, 26 days, the nearest nanosecond is the one that was written.
inline constexpr Duration longest_in_hdf5{std::int64_t{1} << 51};

// What NWB asks to be told of a session.
struct NwbSession {
    std::string description = "Address events";
    // Of the events' time zero; unknown to a scene, so the caller says it.
    std::chrono::system_clock::time_point start;
    std::chrono::system_clock::time_point created;
};

// Sorted events. `not_allowed` beyond longest_in_hdf5, `closed` where it cannot be written.
Result<void> write_sonata(const std::filesystem::path& file, std::span<const Event> events);
Result<void> write_nwb(const std::filesystem::path& file, std::span<const Event> events,
                       const NwbSession& session);

// Sorted by time and address, to the nearest nanosecond. `malformed` says what is not as it must be. A SONATA
// file must have one population; an NWB unit's id is its address.
Result<std::vector<Event>> read_sonata(const std::filesystem::path& file);
Result<std::vector<Event>> read_nwb(const std::filesystem::path& file);

}  // namespace afferent
