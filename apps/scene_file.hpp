// A scene that a command writes for others to read.
#pragma once

#include <filesystem>
#include <string>

#include "afferent/scene/scene.hpp"

namespace afferent {

// Writes the scene into that folder, or into the unfinished one that will take its place, with a first line
// that says which scene it was and by what it was made. It reads the same tables and keys from there. Throws
// Failure.
void write_scene(Scene scene, const std::string& made_by, const std::filesystem::path& file,
                 const std::filesystem::path& folder);

}  // namespace afferent
