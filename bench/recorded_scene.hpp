// A scene file as a scene of the error benchmark: the drives that its neurons get.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/error_scene.hpp"

namespace afferent {

// Runs the scene to record them. Throws SceneError or std::runtime_error.
bench::ErrorScene recorded_scene(const std::filesystem::path& file, bool quick);

// The benchmark's own scenes by name, all of them if there are no names; a name that is none of theirs is a
// scene file. Throws as recorded_scene().
std::vector<bench::ErrorScene> named_scenes(const std::vector<std::string>& names, bool quick);

}  // namespace afferent
