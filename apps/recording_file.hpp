// Where a run is recorded.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "afferent/scene/plan.hpp"

namespace afferent {

// The scene's file, or the one that --record names. Throws Failure where the two contradict each other, and
// where the link has no packets.
std::optional<std::filesystem::path> recording_file(const Plan& plan, const std::string& record);

}  // namespace afferent
