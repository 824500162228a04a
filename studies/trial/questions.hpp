// The questions that a trial answers by many presentations: which condition breaks fewer objects, what moves
// the figures, what lost and late packets do, and what each element of the chain is worth.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "afferent/scene/scene.hpp"
#include "afferent/studies/trial/calibration.hpp"
#include "afferent/studies/trial/numbers.hpp"
#include "afferent/studies/trial/presentation.hpp"
#include "afferent/studies/trial/published.hpp"
#include "afferent/studies/trial/tally.hpp"

namespace afferent {

// The presentations of one condition.
struct TrialRows {
    std::string condition;
    std::vector<Presentation> presentations;
    Tallies tallies;  // of them
    // What the paper has, if anything. None where EMG was recorded: that is another user than the calibrated.
    std::optional<Published> paper;
};

// One condition of a scene in which something has been changed.
struct TrialCell {
    std::string changed;  // a path in the scene, or an ablation; empty: nothing
    std::optional<double> value;
    std::string condition;
    Tallies tallies;
};

// A panel for each path that has been changed: broken objects against its value, and the value of the scene.
struct SensitivityPanel {
    std::string path;
    std::string title;
    double scene_value;
    double scale = 1;  // of its value in the picture
};

// The same presentation under each condition.
struct TracedGrasp {
    std::string condition;
    Presentation presentation;
    std::vector<TraceStep> steps;
};

// The presentations of each point of a question, and how to follow and stop them.
struct TrialEffort {
    std::vector<std::string> conditions;
    std::uint32_t presentations;
    // Called with the share that is done, every so often; false stops, and what is done comes back.
    std::function<bool(double share)> progress = {};
};

// All of these throw SceneError and SpikeStormError, as Experiment does.

struct ConditionComparison {
    std::vector<TrialRows> rows;
    bool is_whole = true;  // it was not stopped
};
ConditionComparison compare_conditions(const Scene& scene, const TrialEffort& effort);
// The number of a presentation that shows what the conditions differ in: of those that broke without feedback
// and were held with spike rate, where there are any, that of the median peak force. None without a delicate
// object.
std::optional<std::uint32_t> representative(const std::vector<TrialRows>& rows);
// That presentation under every condition; none without a delicate object.
std::vector<TracedGrasp> trace_representative(const Scene& scene, const std::vector<TrialRows>& rows);

struct TrialAnswer {
    std::vector<TrialCell> cells;
    std::vector<SensitivityPanel> panels;
    bool is_whole = true;
};
// How the figures of the delicate object move with each number, over its plausible range.
TrialAnswer measure_sensitivity(Scene scene, std::span<const TrialNumber* const> numbers,
                                const TrialEffort& effort);
// How they move with packets that are lost or late.
TrialAnswer measure_faults(const Scene& scene, const TrialEffort& effort);
// Without adaptation, with one neuron in place of one for each element, with transient neurons.
TrialAnswer measure_ablations(const Scene& scene, const TrialEffort& effort);

}  // namespace afferent
