// A link that is a file: packets in one direction, and no peer.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "afferent/apps/side_options.hpp"
#include "afferent/scene/plan.hpp"

namespace afferent {

// The file to which a run is to be recorded: the scene's, or the one that --record names. Throws Failure
// where the two contradict each other, and where the link has no packets.
std::optional<std::filesystem::path> recording_file(const Plan& plan, const std::string& record);

// Runs the coprocessor's side into the scene's file. False: its link is not a file. Throws Failure or
// Interrupted.
bool send_to_file(const SideOptions& options);

// Runs the hand's side from that file: a replay, in lockstep as fast as it goes.
bool receive_from_file(const SideOptions& options);

}  // namespace afferent
