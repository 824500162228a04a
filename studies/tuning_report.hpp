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

// Of a patch, whose afferents are at least one: what summary_of() has of each, the quartiles of what is
// found, a row for each, and maps.
Summary summary_of(const std::vector<AfferentTuning>& patch);
void print(const std::vector<AfferentTuning>& patch, std::ostream& out);
Result<void> write_map(const std::vector<AfferentTuning>& patch, const std::filesystem::path& file);
SkinMaps tuning_maps(const std::vector<AfferentTuning>& patch);

}  // namespace afferent
