// A link that is a file: packets one way, and no peer.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "afferent/apps/side_options.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// Where a run is to be recorded: the scene's file, or what --record says. Throws Failure where that makes no
// sense.
std::optional<std::filesystem::path> recording_file(const Scene& scene, const std::string& record);

// The coprocessor's side, into the scene's file; false: its link is none. Throws Failure or Interrupted.
bool send_to_file(const SideOptions& options);

// The hand's side, out of it: a replay, with lockstep as fast as it goes.
bool receive_from_file(const SideOptions& options);

}  // namespace afferent
