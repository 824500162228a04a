#include "afferent/studies/trial/questions.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "afferent/studies/trial/ablations.hpp"
#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/stoppable_experiments.hpp"

namespace afferent {
namespace {

// Only such a scene is compared with the figures of the paper: simulated users, a radio, and no brake.
bool has_the_papers_arrangement(const Scene& scene) {
    return !scene.hand.emg_table && !scene.gain.brake && scene.trial->connection_interval_ms > 0;
}

// For so many points, each under every condition.
StoppableExperiments experiments_of(const TrialEffort& effort, std::size_t points) {
    return {effort.progress, static_cast<double>(effort.presentations) * static_cast<double>(points) *
                                 static_cast<double>(effort.conditions.size())};
}

// A value of a number, of whose path a panel may be drawn.
struct NumberSetting {
    std::string path;
    double value;
};

// Every setting under every condition. A point that was stopped is left out.
void present_each(StoppableExperiments& experiments, const Scene& scene,
                  const std::vector<NumberSetting>& settings, const TrialEffort& effort,
                  std::vector<TrialCell>& cells) {
    for (const auto& [path, value] : settings)
        for (const std::string& each : effort.conditions) {
            const auto presented = experiments.present(with_number(scene, *find_trial_number(path), value),
                                                       each, 0, effort.presentations);
            if (experiments.is_stopped()) return;
            cells.push_back({path, value, each, tally(presented)});
        }
}

SensitivityPanel panel_of(const Scene& scene, std::string path, std::string title, double scale = 1) {
    const double value = value_in(scene, *find_trial_number(path));
    return {std::move(path), std::move(title), value, scale};
}

std::vector<SensitivityPanel> sensitivity_panels(const Scene& scene,
                                                 std::span<const TrialNumber* const> asked) {
    std::vector<SensitivityPanel> panels{
        panel_of(scene, "gain.lambda_n", "lambda of the gain (N)"),
        panel_of(scene, "trial.object.breaking_spread", "spread of breaking forces"),
        panel_of(scene, "trial.user.reaction_ms", "reaction time (ms)"),
        panel_of(scene, "trial.connection_interval_ms", "connection interval of the radio (ms)"),
        panel_of(scene, "link.channel.loss", "lost packets (%)", 100),
        panel_of(scene, "trial.user.reach_effort", "effort of the reach")};
    std::erase_if(panels, [&](const SensitivityPanel& panel) {
        return std::ranges::find(asked, panel.path, &TrialNumber::path) == asked.end();
    });
    return panels;
}

// The drawn asked in steps over their plausible ranges, and the others at both ends of theirs.
std::vector<NumberSetting> sensitivity_settings(const std::vector<SensitivityPanel>& panels,
                                                std::span<const TrialNumber* const> asked) {
    constexpr int steps = 5;
    std::vector<NumberSetting> settings;
    for (const TrialNumber* number : asked) {
        const bool is_drawn =
            std::ranges::find(panels, number->path, &SensitivityPanel::path) != panels.end();
        const int last = is_drawn ? steps - 1 : 1;
        for (int i = 0; i <= last; ++i)
            settings.push_back(
                {std::string(number->path), std::lerp(number->low, number->high, 1.0 * i / last)});
    }
    return settings;
}

}  // namespace

ConditionComparison compare_conditions(const Scene& scene, const TrialEffort& effort) {
    StoppableExperiments experiments = experiments_of(effort, 1);
    ConditionComparison comparison;
    for (const std::string& each : effort.conditions) {
        auto presented = experiments.present(scene, each, 0, effort.presentations);
        if (presented.empty()) break;
        const Tallies tallies = tally(presented);
        comparison.rows.push_back(
            {each, std::move(presented), tallies,
             has_the_papers_arrangement(condition(each).applied_to(scene)) ? published(each) : std::nullopt});
    }
    comparison.is_whole = !experiments.is_stopped();
    return comparison;
}

std::optional<std::uint32_t> representative(const std::vector<TrialRows>& rows) {
    if (rows.empty()) return std::nullopt;
    const auto of = [&](std::string_view condition) {
        return std::ranges::find(rows, condition, &TrialRows::condition);
    };
    const TrialRows& reference = of("none") == rows.end() ? rows.front() : *of("none");
    const auto rate = of("rate");
    std::vector<const Presentation*> telling;
    std::vector<const Presentation*> delicate;
    for (std::size_t i = 0; i < reference.presentations.size(); ++i) {
        const Presentation& one = reference.presentations[i];
        if (one.slippery) continue;
        delicate.push_back(&one);
        const bool is_saved = rate == rows.end() || (i < rate->presentations.size() &&
                                                     rate->presentations[i].outcome == Outcome::held);
        if (one.outcome == Outcome::broken && is_saved) telling.push_back(&one);
    }
    auto& chosen = telling.empty() ? delicate : telling;
    if (chosen.empty()) return std::nullopt;
    const auto middle = chosen.begin() + static_cast<std::ptrdiff_t>(chosen.size() / 2);
    std::ranges::nth_element(chosen, middle, std::less<>(),
                             [](const Presentation* one) { return one->peak_force_n; });
    return (*middle)->number;
}

std::vector<TracedGrasp> trace_representative(const Scene& scene, const std::vector<TrialRows>& rows) {
    std::vector<TracedGrasp> grasps;
    const auto number = representative(rows);
    if (!number) return grasps;
    for (const TrialRows& row : rows)
        if (*number < row.presentations.size())
            grasps.push_back(
                {row.condition, row.presentations[*number], Experiment(scene, row.condition).trace(*number)});
    return grasps;
}

TrialAnswer measure_sensitivity(Scene scene, std::span<const TrialNumber* const> numbers,
                                const TrialEffort& effort) {
    scene.trial->slippery.part = 0;
    TrialAnswer answer{.cells = {}, .panels = sensitivity_panels(scene, numbers)};
    const auto settings = sensitivity_settings(answer.panels, numbers);
    StoppableExperiments experiments = experiments_of(effort, settings.size() + 1);
    for (const std::string& each : effort.conditions)
        answer.cells.push_back(
            {"", std::nullopt, each, tally(experiments.present(scene, each, 0, effort.presentations))});
    present_each(experiments, scene, settings, effort, answer.cells);
    answer.is_whole = !experiments.is_stopped();
    return answer;
}

TrialAnswer measure_faults(const Scene& scene, const TrialEffort& effort) {
    std::vector<NumberSetting> settings;
    for (const double loss : {0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0})
        settings.push_back({"link.channel.loss", loss});
    for (const double latency_ms : {5, 10, 20, 30, 40, 50, 60, 80, 100})
        settings.push_back({"link.channel.latency_ms", latency_ms});
    TrialAnswer answer{.cells = {},
                       .panels = {panel_of(scene, "link.channel.loss", "lost packets (%)", 100),
                                  panel_of(scene, "link.channel.latency_ms", "latency of the link (ms)")}};
    StoppableExperiments experiments = experiments_of(effort, settings.size());
    present_each(experiments, scene, settings, effort, answer.cells);
    answer.is_whole = !experiments.is_stopped();
    return answer;
}

TrialAnswer measure_ablations(const Scene& scene, const TrialEffort& effort) {
    StoppableExperiments experiments = experiments_of(effort, ablations().size() + 1);
    TrialAnswer answer;
    const auto add = [&](const std::string& changed, const Scene& of, const std::string& condition) {
        const auto presented = experiments.present(of, condition, 0, effort.presentations);
        if (!presented.empty()) answer.cells.push_back({changed, std::nullopt, condition, tally(presented)});
    };
    for (const std::string& each : effort.conditions) add("", scene, each);
    for (const Ablation& ablation : ablations())
        for (const std::string& each : effort.conditions)
            if (std::ranges::find(ablation.conditions, each) != ablation.conditions.end())
                add(std::string(ablation.name), ablation.applied(scene, each), each);
    answer.is_whole = !experiments.is_stopped();
    return answer;
}

}  // namespace afferent
