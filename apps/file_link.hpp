// A link that is a file: packets in one direction, and no peer.
#pragma once

#include "afferent/apps/end_options.hpp"

namespace afferent {

// Runs the coprocessor's end into the scene's file. False: its link is not a file. Throws Failure or
// Interrupted.
bool send_to_file(const EndOptions& options);

// Runs the hand's end from that file: a replay, in lockstep as fast as it goes.
bool receive_from_file(const EndOptions& options);

}  // namespace afferent
