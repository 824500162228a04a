// A scene of the user's own for the benchmark of errors: the drives that its neurons are given.
#pragma once

#include <filesystem>

#include "bench/error_scene.hpp"

namespace afferent {

// Runs the scene to have them. Throws SceneError or Failure.
bench::ErrorScene recorded_scene(const std::filesystem::path& file, bool quick);

}  // namespace afferent
