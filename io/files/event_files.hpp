// Files of events in other programs' formats, there and back.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "afferent/runtime/event.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

enum class EventFormat {
    csv,           // time_s with nine decimals, address
    event_stream,  // .es, version 2, generic: an address of four bytes, little-endian, at a microsecond
    aedat2,        // AER-DAT 2.0: big-endian address and microsecond, four bytes each
};

// By the ending of the name: .csv, .es, .aedat. `not_allowed` for any other.
Result<EventFormat> format_of(const std::filesystem::path& file);

// Microseconds are rounded down. Later events than a format can hold are refused: after 2^32 microseconds
// (71 minutes) in AEDAT 2, and after 6 days in an Event Stream, where silence takes bytes.
Result<std::vector<std::byte>> write_events(std::span<const Event> events, EventFormat format);

// Sorted by time and address, or `malformed`, with the line or the byte.
Result<std::vector<Event>> read_events(std::span<const std::byte> bytes, EventFormat format);

}  // namespace afferent
