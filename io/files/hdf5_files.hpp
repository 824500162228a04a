// Files of events in HDF5: SONATA's spikes and NWB's units, there and back.
#pragma once

#include <cstdint>

#include "afferent/io/files/hdf5_format.hpp"
#include "afferent/io/files/nwb_file.hpp"
#include "afferent/io/files/sonata_file.hpp"
#include "afferent/runtime/time.hpp"

namespace afferent {

// Both hold times as doubles, in milliseconds or seconds. Division and multiplication together err by 2^-52
// of the time, so below 2^51 ns, 26 days, rounding to the nearest nanosecond gives the time that was written.
inline constexpr Duration longest_in_hdf5{std::int64_t{1} << 51};

}  // namespace afferent
