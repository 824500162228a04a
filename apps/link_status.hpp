// Asks for and shows the state of the ends of a session on this machine.
#pragma once

#include "afferent/apps/summary.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// By end: "coprocessor", "channel", "hand". Without those that do not run on this machine.
Summary ask_ends(const Scene& scene);

// All that each end says.
void show_ends(const Summary& link_ends);
// One line an end: what it has sent and received since `before`.
void show_changes(const Summary& before, const Summary& now, double elapsed_s);

}  // namespace afferent
