// The controller's end of a scene as a process of its own.
#pragma once

#include "afferent/apps/end_options.hpp"

namespace afferent {

struct HandOptions : EndOptions {
    bool apart = false;
    bool zero = false;
};

// Throws Failure or Interrupted.
void run_hand(const HandOptions& options);

}  // namespace afferent
