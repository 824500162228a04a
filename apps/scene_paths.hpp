// The paths of a scene, for one that is written into another folder.
#pragma once

#include <filesystem>
#include <string>

#include "afferent/scene/scene.hpp"

namespace afferent {

// The path of a file as a scene in that folder says it: relative, so that both may be moved together.
std::string path_from(const std::filesystem::path& folder, const std::filesystem::path& file);

// Makes the tables and keys that the scene reads the same ones from that folder. What it writes stays beside
// it.
void move_inputs(Scene& scene, const std::filesystem::path& folder);

}  // namespace afferent
