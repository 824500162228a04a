// A scene file as a scene of the error benchmark: the drives that its neurons get.
#pragma once

#include <filesystem>

#include "bench/error_scene.hpp"

namespace afferent {

// Runs the scene to record them. Throws SceneError or std::runtime_error.
bench::ErrorScene recorded_scene(const std::filesystem::path& file, bool quick);

}  // namespace afferent
