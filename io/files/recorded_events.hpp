// The events of a recording: what its packets carried.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/io/wire/result.hpp"
#include "afferent/runtime/event.hpp"

namespace afferent {

struct RecordedEvents {
    std::vector<Event> events;  // of all sessions, sorted by time and address
    std::uint64_t sessions = 0;
    bool closed = false;  // otherwise the recording may end early
};

// `session_ended` is told at the end of each session what it received. `malformed` if the file is not a
// recording, or has packets before any hello.
Result<RecordedEvents> read_recorded_events(const std::filesystem::path& file,
                                            const std::function<void(const PacketCounts&)>& session_ended);

}  // namespace afferent
