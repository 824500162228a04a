// The summaries of runs, nodes and replays, for people and for programs.
#pragma once

#include <cstdint>
#include <optional>

#include "afferent/io/links/session.hpp"
#include "afferent/io/wire/event_bus.hpp"
#include "afferent/nodes/coprocessor_node.hpp"
#include "afferent/nodes/force_error.hpp"
#include "afferent/nodes/hand_node.hpp"
#include "afferent/nodes/pacer.hpp"
#include "afferent/nodes/replay.hpp"
#include "afferent/nodes/run.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

const char* name(GripState state);
// How a session stands; there may be none.
const char* name(const Session* session);

// How far a node has come in its scene.
void add_progress(Summary& summary, const char* link_end, const Scene& scene, TimePoint until);
// From samples to packets.
void add_coprocessor(Summary& summary, const CoprocessorEnd& link_end);
// Nothing where there is no bus.
void add_bus(Summary& summary, const EventBus* bus);
// How well the run kept to the wall clock. Without a pacer it missed no deadline.
void add_pace(Summary& summary, const std::optional<Pacer>& pacer);

// The summary of a node at its end, and its status while it runs, for `afferent link status`. They lack the
// force error, which the node does not know.
Summary summary_of(const HandNode& node);
Summary status_of(const HandNode& node);
Summary summary_of(const CoprocessorNode& node);
Summary status_of(const CoprocessorNode& node);

// The summary of a run that ended at `end`, without how long it took.
Summary summary_of(const Run& run, TimePoint end, const ForceError& error, const std::optional<Pacer>& pacer);
// The same for a replay that began at `from_s`.
Summary summary_of(const Replay& replay, double from_s, const ForceError& error,
                   const std::vector<scene::Output>& outputs);

}  // namespace afferent
