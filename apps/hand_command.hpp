// The controller's end of a scene as a process of its own.
#pragma once

#include "afferent/apps/end_options.hpp"

namespace afferent {

// Throws Failure or Interrupted.
void run_hand(const EndOptions& options);

}  // namespace afferent
