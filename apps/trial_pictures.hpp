// The pictures of a trial.
#pragma once

#include <filesystem>
#include <vector>

#include "afferent/apps/trial_report.hpp"
#include "afferent/io/pictures/gnuplot.hpp"

namespace afferent {

// Broken and dropped objects for each condition, and the paper's figures beside them.
Drawing draw_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& stem);

// The same presentation under each condition.
struct TracedGrasp {
    std::string condition;
    Presentation presentation;
    std::vector<TraceStep> steps;
};
// The number of a presentation that shows what the conditions differ in: of those that broke without feedback
// and were held with spike rate, where there are any, that of the median peak force. None without a delicate
// object.
std::optional<std::uint32_t> representative(const std::vector<TrialRows>& rows);
Drawing draw_grasps(const std::vector<TracedGrasp>& grasps, const std::filesystem::path& stem);

// A panel for each path that has been changed: broken objects against its value, and the value of the scene.
struct SensitivityPanel {
    std::string path;
    std::string title;
    double scene_value;
    double scale = 1;  // of its value in the picture
};
Drawing draw_sensitivity(const std::vector<TrialCell>& cells, const std::vector<SensitivityPanel>& panels,
                         const std::filesystem::path& stem);
// The same panels, in columns, of broken, dropped and safe presentations.
Drawing draw_faults(const std::vector<TrialCell>& cells, const std::vector<SensitivityPanel>& panels,
                    const std::filesystem::path& stem);
// Broken objects for each condition, with the whole chain and with each part of it taken out or added.
Drawing draw_ablations(const std::vector<TrialCell>& cells, const std::filesystem::path& stem);

}  // namespace afferent
