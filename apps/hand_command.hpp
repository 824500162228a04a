// The controller's end of a scene as a process of its own.
#pragma once

#include "afferent/apps/end_options.hpp"

namespace afferent {

struct HandOptions : EndOptions {
    bool apart = false;
    bool zero = false;
    bool with_chip = false;  // run the coprocessor of a scene with a chip, too
};

// Throws Failure or Interrupted.
void run_hand(const HandOptions& options);

}  // namespace afferent
