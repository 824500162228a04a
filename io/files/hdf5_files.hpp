// Files of events in HDF5: SONATA's spikes and NWB's units, there and back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "afferent/io/files/nwb_file.hpp"
#include "afferent/io/files/sonata_file.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

enum class Hdf5Format {
    // *.sonata.h5: /spikes/afferent with timestamps in ms and node_ids, by time (SONATA developer guide).
    sonata,
    // *.nwb: NWB 2's table /units: id, spike_times in s and where each unit's end.
    nwb,
};

// By the ending of the name; nothing for any other ending.
std::optional<Hdf5Format> hdf5_format_of(const std::filesystem::path& file);

// Both hold times as doubles, in milliseconds or seconds. Division and multiplication back err by 2^-52 of
// the time together, so below 2^51 ns, 26 days, the nearest nanosecond is the one that was written.
inline constexpr Duration longest_in_hdf5{std::int64_t{1} << 51};

}  // namespace afferent
