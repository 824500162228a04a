// The clock by which a machine judges silence: its own, which neither a peer nor its operator can set.
#pragma once

#include <chrono>
#include <functional>

namespace afferent {

using MonotonicTime = std::chrono::steady_clock::time_point;
// A parameter, so that tests and virtual time can replace it.
using MonotonicClock = std::function<MonotonicTime()>;

}  // namespace afferent
