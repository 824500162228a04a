// The controller's side of a scene as a process of its own.
#pragma once

#include "afferent/apps/side_options.hpp"

namespace afferent {

// Throws Failure or Interrupted.
void run_hand(const SideOptions& options);

}  // namespace afferent
