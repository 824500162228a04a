// The tuning of an afferent, for people and programs.
#pragma once

#include <filesystem>
#include <ostream>
#include <vector>

#include "afferent/io/pictures/panel_grid.hpp"
#include "afferent/io/pictures/skin_maps.hpp"
#include "afferent/runtime/summary.hpp"
#include "afferent/studies/tuning.hpp"

namespace afferent {

Summary summary_of(const AfferentTuning& tuning);
void print(const AfferentTuning& tuning, std::ostream& out);
// Field, tuning curve, rate against depth, and intervals.
PanelGrid tuning_picture(const AfferentTuning& tuning);

// The same for a patch, by the tuning of each of its afferents; there is at least one. The summary has that
// of each afferent, the text has quartiles, and the table, like the maps, has what is found at each place.
Summary summary_of(const std::vector<AfferentTuning>& patch);
void print(const std::vector<AfferentTuning>& patch, std::ostream& out);
Result<void> write_map(const std::vector<AfferentTuning>& patch, const std::filesystem::path& file);
SkinMaps tuning_maps(const std::vector<AfferentTuning>& patch);

}  // namespace afferent
