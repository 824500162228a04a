// The pictures of a trial.
#pragma once

#include <filesystem>
#include <vector>

#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/studies/trial/questions.hpp"

namespace afferent {

// Broken and dropped objects for each condition, and the paper's figures beside them.
Drawing draw_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& stem);
Drawing draw_grasps(const std::vector<TracedGrasp>& grasps, const std::filesystem::path& stem);
// Broken objects against the value of each panel's number.
Drawing draw_sensitivity(const TrialAnswer& answer, const std::filesystem::path& stem);
// The same panels, in columns, of broken, dropped and safe presentations.
Drawing draw_faults(const TrialAnswer& answer, const std::filesystem::path& stem);
// Broken objects for each condition, with the whole chain and with each element of it taken out or added.
Drawing draw_ablations(const TrialAnswer& answer, const std::filesystem::path& stem);

}  // namespace afferent
