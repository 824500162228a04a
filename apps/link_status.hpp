// Asks for and shows the state of the sides of a session on this machine.
#pragma once

#include "afferent/apps/summary.hpp"
#include "afferent/scene/scene.hpp"

namespace afferent {

// By side: "coprocessor", "channel", "hand". Without those that do not run on this machine.
Summary ask_sides(const Scene& scene);

// All that each side says.
void show_sides(const Summary& sides);
// One line a side: what it has sent and received since `before`.
void show_changes(const Summary& before, const Summary& now, double elapsed_s);

}  // namespace afferent
