// What the summaries of several commands have in common.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/apps/pacer.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/links/session.hpp"
#include "afferent/io/wire/event_bus.hpp"
#include "afferent/nodes/coprocessor_side.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// How far a side has got in its scene.
void add_progress(Summary& summary, const char* side, const Scene& scene, TimePoint until);
// The time it has reached and the state of its session, for `afferent link status`.
void add_standing(Summary& status, const Scene& scene, TimePoint at, const Session* session,
                  std::uint64_t sessions);
// From samples to packets.
void add_coprocessor(Summary& summary, const CoprocessorSide& side);
// Nothing where there is no bus.
void add_bus(Summary& summary, const EventBus* bus);
// How well it kept to the wall clock. Without a pacer it missed no deadline.
void add_pace(Summary& summary, const std::optional<Pacer>& pacer);

// The traffic and the faults of one side's link, summed over all of its sessions.
struct LinkTotals {
    std::uint64_t bytes_sent = 0;
    std::uint64_t bytes_received = 0;
    std::uint64_t dropped_packets = 0;
    std::uint64_t checksum_failures = 0;
    std::uint64_t refused_frames = 0;
    std::uint64_t forged_datagrams = 0;
    std::uint64_t repeated_datagrams = 0;

    void add(const Session& session);
    void add_to(Summary& summary) const;
};

}  // namespace afferent
