// The monotonic clock that measures silence on a link. Included by programs that poll nodes.
#pragma once

#include <chrono>
#include <functional>

#include "afferent/runtime/time.hpp"

namespace afferent {

using MonotonicTime = std::chrono::steady_clock::time_point;
// Passed as a parameter, so that tests can replace it.
using MonotonicClock = std::function<MonotonicTime()>;

// Conversions for virtual time, in which the scene's clock is the only one.
inline MonotonicTime wall_time(TimePoint time) { return MonotonicTime(time - scene_start); }
inline TimePoint virtual_time(MonotonicTime time) { return scene_start + time.time_since_epoch(); }

}  // namespace afferent
