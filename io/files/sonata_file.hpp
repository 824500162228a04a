// Events in SONATA's files of spikes.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "afferent/io/wire/result.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

// Sorted events. `not_allowed` beyond longest_in_hdf5, `closed` where the file cannot be written.
Result<void> write_sonata(const std::filesystem::path& file, std::span<const Event> events);

// Sorted by time and address, to the nearest nanosecond. The file must have one population. `malformed` names
// what is wrong and where.
Result<std::vector<Event>> read_sonata(const std::filesystem::path& file);

}  // namespace afferent
