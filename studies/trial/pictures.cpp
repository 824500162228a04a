#include "afferent/studies/trial/pictures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "afferent/io/pictures/bar_picture.hpp"
#include "afferent/io/pictures/panel_grid.hpp"
#include "afferent/studies/trial/ablations.hpp"
#include "afferent/studies/trial/condition.hpp"
#include "afferent/studies/trial/numbers.hpp"
#include "afferent/studies/trial/percent.hpp"
#include "afferent/studies/trial/published.hpp"

namespace afferent {
namespace {

std::optional<BarPicture::Bar> bar_of(const Proportion& proportion) {
    if (proportion.of == 0) return std::nullopt;
    const Bounds interval = interval_95(proportion);
    return BarPicture::Bar{percent(proportion), 100 * interval.low, 100 * interval.high};
}

using Share = std::function<Proportion(const TrialCell&)>;

// A curve for each condition, in the order in which they first come.
std::vector<PanelGrid::Curve> curves_of(const std::vector<TrialCell>& cells, const SensitivityPanel& panel,
                                        const Share& share) {
    std::vector<PanelGrid::Curve> curves;
    for (const TrialCell& cell : cells) {
        const Proportion counted = share(cell);
        if (cell.changed != panel.path || !cell.value || counted.of == 0) continue;
        auto curve = std::ranges::find(curves, cell.condition, &PanelGrid::Curve::name);
        if (curve == curves.end())
            curve = curves.insert(curves.end(), {.name = cell.condition, .x = {}, .y = {}, .marked = true});
        const Bounds interval = interval_95(counted);
        curve->x.push_back(panel.scale * *cell.value);
        curve->y.push_back(percent(counted));
        curve->low.push_back(100 * interval.low);
        curve->high.push_back(100 * interval.high);
    }
    return curves;
}

// The highest share that is drawn anywhere.
double highest_of(const std::vector<TrialCell>& cells, const std::vector<SensitivityPanel>& panels,
                  const Share& share) {
    double highest = 0;
    for (const TrialCell& cell : cells)
        if (share(cell).of > 0 &&
            std::ranges::find(panels, cell.changed, &SensitivityPanel::path) != panels.end())
            highest = std::max(highest, 100 * interval_95(share(cell)).high);
    return highest;
}

PanelGrid::Panel force_panel(const TracedGrasp& grasp, double highest_n, double longest_s) {
    PanelGrid::Panel panel{.title = grasp.condition + ": " + name(grasp.presentation.outcome),
                           .x_title = "",
                           .y_title = "force (N)",
                           .curves = {{.name = "grip force", .x = {}, .y = {}}},
                           .levels = {},
                           .y_range = std::pair(0.0, highest_n),
                           .x_range = std::pair(0.0, longest_s)};
    const bool has_estimate = condition(grasp.condition).feed != Condition::Feed::nothing;
    if (has_estimate) panel.curves.push_back({.name = "estimate", .x = {}, .y = {}});
    for (const TraceStep& step : grasp.steps) {
        panel.curves[0].x.push_back(step.time_s);
        panel.curves[0].y.push_back(step.force_n);
        if (!has_estimate) continue;
        panel.curves[1].x.push_back(step.time_s);
        panel.curves[1].y.push_back(step.estimate_n);
    }
    if (grasp.presentation.breaking_force_n)
        panel.levels.push_back({"breaking force", *grasp.presentation.breaking_force_n});
    return panel;
}

PanelGrid::Panel gain_panel(const TracedGrasp& grasp, double longest_s) {
    PanelGrid::Panel panel{.title = "",
                           .x_title = "time (s)",
                           .y_title = "gain, effort",
                           .curves = {{.name = "EMG gain", .x = {}, .y = {}},
                                      {.name = "closing EMG", .x = {}, .y = {}},
                                      {.name = "motor command", .x = {}, .y = {}}},
                           .levels = {},
                           .y_range = std::pair(0.0, 1.05),
                           .x_range = std::pair(0.0, longest_s)};
    for (const TraceStep& step : grasp.steps) {
        const double values[] = {step.gain, step.closing, step.command};
        for (std::size_t i = 0; i < panel.curves.size(); ++i) {
            panel.curves[i].x.push_back(step.time_s);
            panel.curves[i].y.push_back(values[i]);
        }
    }
    return panel;
}

}  // namespace

Drawing draw_conditions(const std::vector<TrialRows>& rows, const std::filesystem::path& stem) {
    const bool has_paper =
        std::ranges::any_of(rows, [](const TrialRows& row) { return row.paper.has_value(); });
    BarPicture picture{
        .title = "Delicate objects that break, by what the EMG gain goes by",
        .y_title = "objects (%)",
        .names = {},
        .series = {{.name = "broken here", .bars = {}},
                   {.name = "dropped here", .bars = {}},
                   {.name = "broken in the paper", .bars = {}, .is_reference = true}},
        .note = has_paper ? "Lines: 95 % intervals; the paper's of 200 presentations each, as inferred. "
                            "Calibrated: none and force. Predicted: all others."
                          : "Lines: 95 % intervals."};
    for (const TrialRows& row : rows) {
        const Tally& tally = row.tallies.delicate;
        picture.names.push_back(row.condition);
        picture.series[0].bars.push_back(bar_of(tally.broken()));
        picture.series[1].bars.push_back(bar_of(tally.dropped()));
        const auto& found = row.paper;
        picture.series[2].bars.push_back(found ? bar_of(found->broken) : std::nullopt);
    }
    return draw(picture, stem);
}

Drawing draw_grasps(const std::vector<TracedGrasp>& grasps, const std::filesystem::path& stem) {
    if (grasps.empty()) return {Drawn::failed, "there is nothing to draw"};
    constexpr std::size_t most_columns = 4;
    PanelGrid picture{.title = "The same user, object and noise under each condition: presentation " +
                               std::to_string(grasps.front().presentation.number),
                      .columns = std::min(most_columns, grasps.size()),
                      .panels = {},
                      .panel_height = 150};
    // Room for an estimate that overshoots, but not for any.
    const double breaking_n = grasps.front().presentation.breaking_force_n.value_or(0);
    double highest_n = breaking_n;
    double longest_s = 0;
    for (const TracedGrasp& grasp : grasps)
        for (const TraceStep& step : grasp.steps) {
            highest_n = std::max({highest_n, step.force_n, std::min(step.estimate_n, 1.6 * breaking_n)});
            longest_s = std::max(longest_s, step.time_s);
        }
    for (std::size_t first = 0; first < grasps.size(); first += picture.columns) {
        const std::size_t last = std::min(first + picture.columns, grasps.size());
        for (std::size_t i = first; i < last; ++i)
            picture.panels.push_back(force_panel(grasps[i], 1.05 * highest_n, longest_s));
        // The last row may be short; what is below stays below.
        for (std::size_t i = last; i < first + picture.columns; ++i) picture.panels.push_back({});
        for (std::size_t i = first; i < last; ++i) picture.panels.push_back(gain_panel(grasps[i], longest_s));
    }
    return draw(picture, stem);
}

Drawing draw_sensitivity(const TrialAnswer& answer, const std::filesystem::path& stem) {
    const auto& [cells, panels, is_whole] = answer;
    PanelGrid picture{
        .title = "How the three figures move with what the paper does not give", .columns = 3, .panels = {}};
    const Share broken = [](const TrialCell& cell) { return cell.tallies.delicate.broken(); };
    const double highest = 1.05 * highest_of(cells, panels, broken);
    for (const SensitivityPanel& panel : panels) {
        PanelGrid::Panel drawn{.title = "",
                               .x_title = panel.title,
                               .y_title = "broken (%)",
                               .curves = curves_of(cells, panel, broken),
                               .levels = {},
                               .y_range = std::pair(0.0, highest)};
        // A radio that the scene has none of has no interval between the plausible ones.
        const TrialNumber& number = *find_trial_number(panel.path);
        if (number.low <= panel.scene_value && panel.scene_value <= number.high)
            drawn.levels.push_back({"the scene's own value", panel.scale * panel.scene_value, true});
        picture.panels.push_back(std::move(drawn));
    }
    return draw(picture, stem);
}

Drawing draw_faults(const TrialAnswer& answer, const std::filesystem::path& stem) {
    const auto& [cells, panels, is_whole] = answer;
    struct Row {
        const char* title;
        Share share;
    };
    const Row rows[] = {
        {"delicate, broken (%)", [](const TrialCell& cell) { return cell.tallies.delicate.broken(); }},
        {"delicate, dropped (%)", [](const TrialCell& cell) { return cell.tallies.delicate.dropped(); }},
        {"heavy, dropped (%)", [](const TrialCell& cell) { return cell.tallies.slippery.dropped(); }},
        {"safe state (%)", [](const TrialCell& cell) { return cell.tallies.delicate.safe_state(); }},
    };
    PanelGrid picture{.title = "What a link that loses or delays does to the objects",
                      .columns = panels.size(),
                      .panels = {},
                      .panel_height = 140};
    for (const Row& row : rows) {
        const double highest = std::max(1.0, 1.05 * highest_of(cells, panels, row.share));
        for (const SensitivityPanel& panel : panels)
            picture.panels.push_back({.title = "",
                                      .x_title = panel.title,
                                      .y_title = row.title,
                                      .curves = curves_of(cells, panel, row.share),
                                      .levels = {},
                                      .y_range = std::pair(0.0, highest)});
    }
    return draw(picture, stem);
}

Drawing draw_ablations(const TrialAnswer& answer, const std::filesystem::path& stem) {
    const auto& cells = answer.cells;
    BarPicture picture{.title = "Delicate objects that break, with a part of the chain taken out or added",
                       .y_title = "broken (%)",
                       .names = {},
                       .series = {},
                       .note = "Lines: 95 % intervals. Nothing is calibrated again."};
    for (const TrialCell& cell : cells)
        if (std::ranges::find(picture.names, cell.condition) == picture.names.end())
            picture.names.push_back(cell.condition);
    for (const TrialCell& cell : cells) {
        const Ablation* ablation = find_ablation(cell.changed);
        const std::string name(ablation ? ablation->words : "the whole chain");
        auto series = std::ranges::find(picture.series, name, &BarPicture::Series::name);
        if (series == picture.series.end()) {
            series = picture.series.insert(series, {.name = name, .bars = {}});
            series->bars.resize(picture.names.size());
        }
        const auto place = std::ranges::find(picture.names, cell.condition) - picture.names.begin();
        series->bars[static_cast<std::size_t>(place)] = bar_of(cell.tallies.delicate.broken());
    }
    return draw(picture, stem);
}

}  // namespace afferent
