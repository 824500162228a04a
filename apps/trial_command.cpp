// afferent trial: does it break fewer crackers?
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <limits>
#include <memory>
#include <sstream>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/trial_pictures.hpp"
#include "afferent/apps/trial_report.hpp"
#include "afferent/scene/nearest_name.hpp"
#include "afferent/studies/trial/ablations.hpp"
#include "afferent/studies/trial/calibration.hpp"
#include "afferent/studies/trial/experiment.hpp"
#include "afferent/studies/trial/numbers.hpp"
#include "afferent/studies/trial/published.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

struct TrialOptions {
    std::string file;
    std::uint64_t presentations = 0;  // 0: what is usual for what is asked
    std::string conditions;
    std::string numbers;
    std::string out;
    std::vector<std::string> settings;
    std::int64_t seed = -1;  // < 0: the scene's own
    std::int64_t threads = -1;
    bool calibrate = false;
    bool sensitivity = false;
    bool faults = false;
    bool ablations = false;
    bool json = false;
};

// One fifth of the presentations are of the heavy object, so that 20,000 are of the one that breaks.
constexpr std::uint32_t usual_presentations = 25'000;
constexpr std::uint32_t usual_calibration = 20'000;
// At each of many points, which share their presentations: their differences are known better than each of
// them.
constexpr std::uint32_t usual_at_a_point = 2'000;

Scene scene_of(const TrialOptions& options) {
    Scene scene = Scene::from_file(options.file, settings_of(options.settings));
    if (options.seed >= 0) scene.seed = static_cast<std::uint64_t>(options.seed);
    if (options.threads >= 0) scene.runtime.threads = static_cast<std::uint32_t>(options.threads);
    if (!scene.trial) throw Failure(options.file + ": has no trial { ... }; examples/trial.txtpb has one");
    return scene;
}

std::vector<std::string> listed(const std::string& option, const std::string& list) {
    std::vector<std::string> names;
    std::istringstream in(list);
    for (std::string each; std::getline(in, each, ',');) {
        if (std::ranges::find(names, each) != names.end())
            throw Failure(option + ": \"" + each + "\" stands there twice");
        names.push_back(each);
    }
    return names;
}

std::vector<std::string> conditions_of(const TrialOptions& options, const std::vector<std::string>& usual) {
    if (options.conditions.empty()) return usual;
    std::vector<std::string> chosen = listed("--conditions", options.conditions);
    for (const std::string& each : chosen) (void)condition(each);
    return chosen;
}

std::vector<const TrialNumber*> numbers_of(const TrialOptions& options) {
    std::vector<const TrialNumber*> chosen;
    if (options.numbers.empty())
        for (const TrialNumber& number : trial_numbers()) chosen.push_back(&number);
    for (const std::string& each : listed("--numbers", options.numbers)) {
        chosen.push_back(find_trial_number(each));
        if (chosen.back()) continue;
        std::vector<std::string> paths;
        for (const TrialNumber& number : trial_numbers()) paths.emplace_back(number.path);
        const auto nearest = nearest_name(each, paths);
        throw Failure("--numbers: there is no \"" + each + '"' +
                      (nearest ? "; did you mean " + *nearest + "?" : ""));
    }
    return chosen;
}

// Presents, shows how far it has come, and ends at Ctrl-C with what is done.
class Presenting {
  public:
    Presenting(std::string what, std::uint64_t all) : progress_(std::move(what)), all_(all) {}

    std::vector<Presentation> present(const Scene& scene, const std::string& condition, std::uint32_t count) {
        if (is_interrupted_) return {};
        const Experiment experiment(scene, condition);
        auto presented = experiment.present(0, count, [&](std::uint32_t done) { return at(done_ + done); });
        done_ += count;
        is_interrupted_ = is_interrupted_ || interrupted();
        return presented;
    }
    bool is_interrupted() const noexcept { return is_interrupted_; }

    bool at(std::uint64_t done) {
        progress_.at(std::min(1.0, static_cast<double>(done) / static_cast<double>(all_)));
        is_interrupted_ = is_interrupted_ || interrupted();
        return !is_interrupted_;
    }

  private:
    Progress progress_;
    std::uint64_t all_;
    std::uint64_t done_ = 0;
    bool is_interrupted_ = false;
};

std::uint32_t presentations_of(const TrialOptions& options, std::uint32_t usual) {
    return options.presentations == 0 ? usual : static_cast<std::uint32_t>(options.presentations);
}

// What every result says of where it comes from.
Summary about(const Scene& scene, std::uint32_t presentations, bool is_interrupted) {
    return {{"scene", scene.name},
            {"seed", scene.seed},
            {"presentations", presentations},
            {"interrupted", is_interrupted}};
}

void append(Summary& summary, const Summary& more) {
    for (const auto& [key, value] : more.entries()) summary[key] = value;
}

// Prints what was found, and where it is, and ends as an interrupted command does where it was.
template <class Print>
void end(const TrialOptions& options, const Summary& summary, bool is_interrupted,
         const Print& print_for_people) {
    if (options.json) {
        print(summary, true);
    } else {
        print_for_people();
        std::cout << '\n'
                  << (options.out.empty() ? "Nothing is written; --out DIR writes tables and pictures"
                                          : "Written to " + options.out)
                  << '\n';
    }
    if (is_interrupted) throw Interrupted();
}

// The same presentation under every condition of which there are any.
std::vector<TracedGrasp> trace(const Scene& scene, const std::vector<TrialRows>& rows) {
    std::vector<TracedGrasp> grasps;
    const auto number = representative(rows);
    if (!number) return grasps;
    for (const TrialRows& row : rows)
        if (*number < row.presentations.size())
            grasps.push_back(
                {row.condition, row.presentations[*number], Experiment(scene, row.condition).trace(*number)});
    return grasps;
}

void compare_conditions(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    const auto conditions = conditions_of(options, condition_names());
    const std::uint32_t count = presentations_of(options, usual_presentations);
    Results results(options.out, {"trial.csv", "trial_summary.csv", "trial_slip.csv", "trial.svg",
                                  "trial.png", "trial_grasps.svg", "trial_grasps.png", "summary.json"});
    Presenting presenting("trial", std::uint64_t{count} * conditions.size());
    std::vector<TrialRows> rows;
    for (const std::string& each : conditions) {
        auto presented = presenting.present(scene, each, count);
        if (presented.empty()) break;
        const Tallies tallies = tally(presented);
        rows.push_back(
            {each, std::move(presented), tallies, scene.hand.emg_table ? std::nullopt : published(each)});
    }
    Summary summary = about(scene, count, presenting.is_interrupted());
    append(summary, summary_of(rows));
    if (results.wanted()) {
        write_presentations(rows, results.file("trial.csv"));
        write_conditions(rows, results.file("trial_summary.csv"));
        write_slips(rows, results.file("trial_slip.csv"));
        if (!rows.empty()) tell_if_undrawn(draw_conditions(rows, results.file("trial")));
        const auto grasps = trace(scene, rows);
        if (!grasps.empty()) tell_if_undrawn(draw_grasps(grasps, results.file("trial_grasps")));
        results.put_in_place(summary, "summary.json");
    }
    end(options, summary, presenting.is_interrupted(), [&] { print_trial(rows, std::cout); });
}

Summary summary_of(const CalibratedNumber& number) {
    const TrialNumber& known = *find_trial_number(number.path);
    const Bounds interval = interval_95(number.found.counted);
    return {{"path", std::string(number.path)},
            {"value", number.found.parameter},
            {"sigma", number.found.sigma},
            {"plausible_low", known.low},
            {"plausible_high", known.high},
            {"is_reached", number.found.is_reached},
            {"condition", std::string(number.condition)},
            {"broken_pct", percent(number.found.counted)},
            {"broken_low_pct", 100 * interval.low},
            {"broken_high_pct", 100 * interval.high},
            {"paper_pct", percent(published(number.condition)->broken)}};
}

void print_calibration(const TrialCalibration& calibration) {
    for (const CalibratedNumber* number : {&calibration.stiffness, &calibration.aim}) {
        const auto& [parameter, counted, sigma, is_reached] = number->found;
        const TrialNumber& known = *find_trial_number(number->path);
        std::cout << std::setprecision(4) << number->path << ": " << parameter << " ± " << sigma
                  << ", within " << known.low << " to " << known.high << ": " << std::setprecision(3)
                  << percent(counted) << " % of " << counted.of
                  << " delicate objects break with the condition " << number->condition << ", in the paper "
                  << percent(published(number->condition)->broken) << " %\n";
        if (!is_reached) std::cout << "  That is the end of its range: the paper's figure is not reached.\n";
    }
}

void calibrate_scene(const TrialOptions& options) {
    if (!options.conditions.empty())
        throw Failure("--calibrate: the conditions are none and force; leave out --conditions");
    const Scene scene = scene_of(options);
    const std::uint32_t count = presentations_of(options, usual_calibration);
    Results results(options.out, {"scene.txtpb", "calibration.json"});
    // How many counts it takes is not known before.
    constexpr std::uint64_t usual_counts = 10;
    Presenting presenting("trial --calibrate", usual_counts * count);
    std::uint64_t all_done = 0;
    const auto calibration = calibrate_trial(
        scene, count, [&](std::string_view, std::uint32_t done) { return presenting.at(all_done += done); });
    if (!calibration) throw Interrupted();
    Summary summary = about(scene, count, false);
    summary["calibrated"].push_back(summary_of(calibration->stiffness));
    summary["calibrated"].push_back(summary_of(calibration->aim));
    if (results.wanted()) {
        const fs::path file = results.file("scene.txtpb");
        std::ofstream out(file);
        out << "# " << options.file << ", calibrated by: afferent trial --calibrate\n"
            << calibration->scene.text(Scene::TextLayout::field_a_line);
        out.close();
        if (!out) throw Failure(file.string() + ": cannot be written");
        results.put_in_place(summary, "calibration.json");
    }
    end(options, summary, false, [&] { print_calibration(*calibration); });
    if (!calibration->is_reached())
        throw Failure("the trial could not be calibrated within the plausible ranges");
}

// A value of a number, of whose path a panel may be drawn.
struct NumberSetting {
    std::string path;
    double value;
};

Scene with(const Scene& scene, const NumberSetting& setting) {
    return with_number(scene, *find_trial_number(setting.path), setting.value);
}

std::vector<TrialCell> present_each(Presenting& presenting, const Scene& scene,
                                    const std::vector<NumberSetting>& settings,
                                    const std::vector<std::string>& conditions, std::uint32_t count) {
    std::vector<TrialCell> cells;
    for (const NumberSetting& setting : settings)
        for (const std::string& each : conditions) {
            const auto presented = presenting.present(with(scene, setting), each, count);
            if (presenting.is_interrupted()) return cells;
            cells.push_back({setting.path, setting.value, each, tally(presented)});
        }
    return cells;
}

SensitivityPanel panel_of(const Scene& scene, std::string path, std::string title, double scale = 1) {
    const double value = value_in(scene, *find_trial_number(path));
    return {std::move(path), std::move(title), value, scale};
}

std::vector<SensitivityPanel> sensitivity_panels(const Scene& scene,
                                                 const std::vector<const TrialNumber*>& numbers) {
    std::vector<SensitivityPanel> panels{
        panel_of(scene, "gain.lambda_n", "lambda of the gain (N)"),
        panel_of(scene, "trial.object.breaking_spread", "spread of breaking forces"),
        panel_of(scene, "trial.user.reaction_ms", "reaction time (ms)"),
        panel_of(scene, "trial.connection_interval_ms", "connection interval of the radio (ms)"),
        panel_of(scene, "link.channel.loss", "lost packets (%)", 100),
        panel_of(scene, "trial.user.reach_effort", "effort of the reach")};
    std::erase_if(panels, [&](const SensitivityPanel& panel) {
        return std::ranges::find(numbers, panel.path, &TrialNumber::path) == numbers.end();
    });
    return panels;
}

// The drawn numbers in steps over their plausible ranges, and the others at both ends of theirs.
std::vector<NumberSetting> sensitivity_settings(const std::vector<SensitivityPanel>& panels,
                                                const std::vector<const TrialNumber*>& numbers) {
    constexpr int steps = 5;
    std::vector<NumberSetting> settings;
    for (const TrialNumber* number : numbers) {
        const bool is_drawn =
            std::ranges::find(panels, number->path, &SensitivityPanel::path) != panels.end();
        const int last = is_drawn ? steps - 1 : 1;
        for (int i = 0; i <= last; ++i)
            settings.push_back(
                {std::string(number->path), std::lerp(number->low, number->high, 1.0 * i / last)});
    }
    return settings;
}

void measure_sensitivity(const TrialOptions& options) {
    Scene scene = scene_of(options);
    scene.trial->slippery.part = 0;
    const auto conditions = conditions_of(options, {"none", "force", "rate"});
    const std::uint32_t count = presentations_of(options, usual_at_a_point);
    Results results(options.out,
                    {"sensitivity.csv", "sensitivity.svg", "sensitivity.png", "sensitivity.json"});
    const auto numbers = numbers_of(options);
    const auto panels = sensitivity_panels(scene, numbers);
    const auto settings = sensitivity_settings(panels, numbers);
    Presenting presenting("trial --sensitivity", (settings.size() + 1) * conditions.size() * count);
    std::vector<TrialCell> cells;
    for (const std::string& each : conditions)
        cells.push_back({"", std::nullopt, each, tally(presenting.present(scene, each, count))});
    for (TrialCell& cell : present_each(presenting, scene, settings, conditions, count))
        cells.push_back(std::move(cell));
    Summary summary = about(scene, count, presenting.is_interrupted());
    for (const TrialNumber* number : numbers)
        summary["numbers"].push_back({{"path", std::string(number->path)},
                                      {"value", value_in(scene, *number)},
                                      {"low", number->low},
                                      {"high", number->high},
                                      {"source", std::string(number->source)}});
    summary["sensitivity"] = summary_of(cells);
    if (results.wanted()) {
        write_cells(cells, results.file("sensitivity.csv"));
        if (!panels.empty()) tell_if_undrawn(draw_sensitivity(cells, panels, results.file("sensitivity")));
        results.put_in_place(summary, "sensitivity.json");
    }
    end(options, summary, presenting.is_interrupted(), [&] { print_cells(cells, std::cout); });
}

void measure_faults(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    const auto conditions = conditions_of(options, {"force", "rate", "filter", "send_on_delta"});
    const std::uint32_t count = presentations_of(options, usual_at_a_point);
    Results results(options.out, {"faults.csv", "faults.svg", "faults.png", "faults.json"});
    std::vector<NumberSetting> settings;
    for (const double loss : {0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0})
        settings.push_back({"link.channel.loss", loss});
    for (const double latency_ms : {5, 10, 20, 30, 40, 50, 60, 80, 100})
        settings.push_back({"link.channel.latency_ms", latency_ms});
    Presenting presenting("trial --faults", settings.size() * conditions.size() * count);
    const auto cells = present_each(presenting, scene, settings, conditions, count);
    Summary summary = about(scene, count, presenting.is_interrupted());
    summary["faults"] = summary_of(cells);
    if (results.wanted()) {
        write_cells(cells, results.file("faults.csv"));
        tell_if_undrawn(draw_faults(cells,
                                    {panel_of(scene, "link.channel.loss", "lost packets (%)", 100),
                                     panel_of(scene, "link.channel.latency_ms", "latency of the link (ms)")},
                                    results.file("faults")));
        results.put_in_place(summary, "faults.json");
    }
    end(options, summary, presenting.is_interrupted(), [&] { print_cells(cells, std::cout); });
}

void measure_ablations(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    const auto conditions = conditions_of(options, {"rate", "filter"});
    const std::uint32_t count = presentations_of(options, usual_presentations);
    Results results(options.out, {"ablations.csv", "ablations.svg", "ablations.png", "ablations.json"});
    Presenting presenting("trial --ablations", (ablations().size() + 1) * conditions.size() * count);
    std::vector<TrialCell> cells;
    const auto add = [&](const std::string& changed, const Scene& of, const std::string& condition) {
        const auto presented = presenting.present(of, condition, count);
        if (!presented.empty()) cells.push_back({changed, std::nullopt, condition, tally(presented)});
    };
    for (const std::string& each : conditions) add("", scene, each);
    for (const Ablation& ablation : ablations())
        for (const std::string& each : conditions)
            if (std::ranges::find(ablation.conditions, each) != ablation.conditions.end())
                add(std::string(ablation.name), ablation.applied(scene, each), each);
    Summary summary = about(scene, count, presenting.is_interrupted());
    summary["ablations"] = summary_of(cells);
    if (results.wanted()) {
        write_cells(cells, results.file("ablations.csv"));
        if (!cells.empty()) tell_if_undrawn(draw_ablations(cells, results.file("ablations")));
        results.put_in_place(summary, "ablations.json");
    }
    end(options, summary, presenting.is_interrupted(), [&] { print_cells(cells, std::cout); });
}

void run_trial(const TrialOptions& options) {
    catch_interrupts();
    if (options.presentations > std::numeric_limits<std::uint32_t>::max())
        throw Failure("--presentations: must be below 2^32");
    if (options.calibrate + options.sensitivity + options.faults + options.ablations > 1)
        throw Failure("--calibrate, --sensitivity, --faults and --ablations: give one of them");
    if (!options.numbers.empty() && !options.sensitivity) throw Failure("--numbers: goes with --sensitivity");
    if (options.calibrate) return calibrate_scene(options);
    if (options.sensitivity) return measure_sensitivity(options);
    if (options.faults) return measure_faults(options);
    if (options.ablations) return measure_ablations(options);
    compare_conditions(options);
}

}  // namespace

Command trial_command() {
    const auto options = std::make_shared<TrialOptions>();
    return {
        .name = "trial",
        .help = "Present delicate objects to a simulated user and hand, and count those that break",
        .footer =
            "Conditions: none, force, rate, exponential, interval, inversion, filter, send_on_delta.\n"
            "Writes trial.csv, with a row for each presentation, trial_summary.csv, trial_slip.csv, and "
            "their "
            "pictures.\nThe same numbers for any number of threads; docs/trial.md says what is calibrated "
            "and "
            "what is predicted.\n"
            "Examples:\n"
            "  afferent trial examples/trial.txtpb --out out/trial\n"
            "  afferent trial examples/trial.txtpb --conditions none,rate --presentations 1000\n"
            "  afferent trial examples/trial.txtpb --calibrate --out out/calibrated",
        .options =
            {
                positional("SCENE", options->file, "A scene with trial { ... }, a Protobuf text file")
                    .required(),
                option("--presentations", options->presentations,
                       "Of each condition; 0: 25000, with --calibrate 20000, with --sensitivity and --faults "
                       "2000 "
                       "at each point")
                    .show_default(),
                option("--conditions", options->conditions,
                       "What the gain goes by, separated by commas; if absent, all, or those that tell most"),
                option("--numbers", options->numbers,
                       "With --sensitivity: only these of the scene, such as trial.user.reaction_ms, "
                       "separated by commas"),
                option("--out", options->out, "Folder for tables and pictures"),
                set_option(options->settings),
                option("--seed", options->seed, "In place of the scene's seed").not_negative(),
                option("--threads", options->threads,
                       "In place of the scene's; 0: as many as the machine has")
                    .not_negative(),
                flag("--calibrate", options->calibrate,
                     "Find the object's stiffness and the user's aim with which as many break as in the "
                     "paper, with force and "
                     "without feedback"),
                flag("--sensitivity", options->sensitivity,
                     "How the figures move with each number that a reader may doubt"),
                flag("--faults", options->faults, "How they move with packets that are lost or late"),
                flag("--ablations", options->ablations,
                     "Without adaptation, with one neuron in place of one for each element, with transient "
                     "neurons"),
                flag("--json", options->json, "Print the results as JSON"),
            },
        .run = [options] { run_trial(*options); },
    };
}

}  // namespace afferent
