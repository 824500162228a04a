// Times of a test, by how long after the scene's start they are.
#pragma once

#include "afferent/runtime/time.hpp"

namespace afferent {

constexpr TimePoint at(Duration since_start) { return scene_start + since_start; }

}  // namespace afferent
