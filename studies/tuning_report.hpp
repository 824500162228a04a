// The tuning of an afferent, for people and programs.
#pragma once

#include <ostream>

#include "afferent/io/pictures/panel_grid.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/studies/tuning.hpp"

namespace afferent {

Summary summary_of(const AfferentTuning& tuning);
void print(const AfferentTuning& tuning, std::ostream& out);
// Field, tuning curve, rate against depth, and intervals.
PanelGrid tuning_picture(const AfferentTuning& tuning);

}  // namespace afferent
