// The events of a recording: what its packets carried.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "afferent/io/files/event_set.hpp"
#include "afferent/io/wire/packet_receiver.hpp"
#include "afferent/runtime/result.hpp"

namespace afferent {

struct RecordedEvents {
    EventSet set;       // of all sessions, with the patches and the tick of the first
    std::string scene;  // as text: it tells more of the afferents
    std::uint64_t sessions = 0;
    bool closed = false;  // otherwise the recording may end early
};

// Calls `session_ended` with what each session received, at its end. `malformed` if the file is not a
// recording, or has packets before any hello.
Result<RecordedEvents> read_recorded_events(const std::filesystem::path& file,
                                            const std::function<void(const PacketCounts&)>& session_ended);

}  // namespace afferent
