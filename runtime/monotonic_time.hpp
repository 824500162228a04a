// The clock by which a machine judges silence: its own, which neither a peer nor its operator can set.
#pragma once

#include <chrono>
#include <functional>

#include "afferent/runtime/time.hpp"

namespace afferent {

using MonotonicTime = std::chrono::steady_clock::time_point;
// A parameter, so that tests and virtual time can replace it.
using MonotonicClock = std::function<MonotonicTime()>;

// Where time is virtual there is one clock, that of the scene.
inline MonotonicTime wall_time(TimePoint time) { return MonotonicTime(time - scene_start); }
inline TimePoint virtual_time(MonotonicTime time) { return scene_start + time.time_since_epoch(); }

}  // namespace afferent
