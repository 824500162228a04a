// afferent trial: does it break fewer crackers?
#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <sstream>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/interrupt.hpp"
#include "afferent/apps/listed.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/results.hpp"
#include "afferent/apps/scene_file.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/scene/nearest_name.hpp"
#include "afferent/studies/trial/calibration.hpp"
#include "afferent/studies/trial/condition.hpp"
#include "afferent/studies/trial/pictures.hpp"
#include "afferent/studies/trial/questions.hpp"
#include "afferent/studies/trial/report.hpp"
#include "afferent/studies/trial/tables.hpp"

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

std::uint32_t presentations_of(const TrialOptions& options, std::uint32_t usual) {
    return options.presentations == 0 ? usual : static_cast<std::uint32_t>(options.presentations);
}

// What every result says of where it comes from.
Summary about(const Scene& scene, const TrialEffort& effort, bool is_interrupted) {
    return {{"scene", scene.name},
            {"seed", scene.seed},
            {"presentations", effort.presentations},
            {"interrupted", is_interrupted}};
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

// Shows how far a question has come, and stops it at Ctrl-C with what is done.
TrialEffort effort_of(const TrialOptions& options, const std::vector<std::string>& usual_conditions,
                      std::uint32_t usual, Progress& progress) {
    return {conditions_of(options, usual_conditions), presentations_of(options, usual), [&](double share) {
                progress.at(share);
                return !interrupted();
            }};
}

void compare(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    Progress progress("trial");
    const TrialEffort effort = effort_of(options, condition_names(), usual_presentations, progress);
    Results results(options.out, {"trial.csv", "trial_summary.csv", "trial_slip.csv", "trial.svg",
                                  "trial.png", "trial_grasps.svg", "trial_grasps.png", "summary.json"});
    const ConditionComparison comparison = compare_conditions(scene, effort);
    const std::vector<TrialRows>& rows = comparison.rows;
    Summary summary = about(scene, effort, !comparison.is_whole);
    append(summary, summary_of(rows));
    if (results.wanted()) {
        value_or_fail(write_presentations(rows, results.file("trial.csv")));
        value_or_fail(write_conditions(rows, results.file("trial_summary.csv")));
        value_or_fail(write_slips(rows, results.file("trial_slip.csv")));
        if (!rows.empty()) tell_if_undrawn(draw_conditions(rows, results.file("trial")));
        const auto grasps = trace_representative(scene, rows);
        if (!grasps.empty()) tell_if_undrawn(draw_grasps(grasps, results.file("trial_grasps")));
        results.put_in_place(summary, "summary.json");
    }
    end(options, summary, !comparison.is_whole, [&] { print_trial(rows, std::cout); });
}

void calibrate_scene(const TrialOptions& options) {
    if (!options.conditions.empty())
        throw Failure("--calibrate: the conditions are none and force; leave out --conditions");
    const Scene scene = scene_of(options);
    const std::uint32_t count = presentations_of(options, usual_calibration);
    Results results(options.out, {"scene.txtpb", "calibration.json"});
    // How many counts it takes is not known before.
    constexpr double usual_counts = 10;
    Progress progress("trial --calibrate");
    std::uint64_t all_done = 0;
    const auto calibration = calibrate_trial(scene, count, [&](std::string_view, std::uint32_t done) {
        progress.at(std::min(1.0, static_cast<double>(all_done += done) / (usual_counts * count)));
        return !interrupted();
    });
    if (!calibration) throw Interrupted();
    Summary summary = about(scene, {{}, count}, false);
    summary["calibrated"] = summary_of(*calibration);
    if (results.wanted()) {
        write_scene(calibration->scene, "calibrated by: afferent trial --calibrate",
                    results.file("scene.txtpb"), options.out);
        results.put_in_place(summary, "calibration.json");
    }
    end(options, summary, false, [&] { print_calibration(*calibration, std::cout); });
    if (!calibration->is_reached())
        throw Failure("the trial could not be calibrated within the plausible ranges");
}

// Writes and prints the answer to one question; `name` is that of its files.
void finish(const TrialOptions& options, const std::string& name, Summary summary, const TrialAnswer& answer,
            Results& results, Drawing (*draw)(const TrialAnswer&, const fs::path&)) {
    summary[name] = summary_of(answer.cells);
    if (results.wanted()) {
        value_or_fail(write_cells(answer.cells, results.file((name + ".csv").c_str())));
        if (!answer.cells.empty()) tell_if_undrawn(draw(answer, results.file(name.c_str())));
        results.put_in_place(summary, (name + ".json").c_str());
    }
    end(options, summary, !answer.is_whole, [&] { print_cells(answer.cells, std::cout); });
}

Results results_of(const TrialOptions& options, const std::string& name) {
    return {options.out, {name + ".csv", name + ".svg", name + ".png", name + ".json"}};
}

void ask_for_sensitivity(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    const auto numbers = numbers_of(options);
    Progress progress("trial --sensitivity");
    const TrialEffort effort = effort_of(options, {"none", "force", "rate"}, usual_at_a_point, progress);
    Results results = results_of(options, "sensitivity");
    const TrialAnswer answer = measure_sensitivity(scene, numbers, effort);
    Summary summary = about(scene, effort, !answer.is_whole);
    summary["numbers"] = summary_of(scene, numbers);
    finish(options, "sensitivity", std::move(summary), answer, results, draw_sensitivity);
}

void ask_for_faults(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    Progress progress("trial --faults");
    const TrialEffort effort =
        effort_of(options, {"force", "rate", "filter", "send_on_delta"}, usual_at_a_point, progress);
    Results results = results_of(options, "faults");
    const TrialAnswer answer = measure_faults(scene, effort);
    finish(options, "faults", about(scene, effort, !answer.is_whole), answer, results, draw_faults);
}

void ask_for_ablations(const TrialOptions& options) {
    const Scene scene = scene_of(options);
    Progress progress("trial --ablations");
    const TrialEffort effort = effort_of(options, {"rate", "filter"}, usual_presentations, progress);
    Results results = results_of(options, "ablations");
    const TrialAnswer answer = measure_ablations(scene, effort);
    finish(options, "ablations", about(scene, effort, !answer.is_whole), answer, results, draw_ablations);
}

void run_trial(const TrialOptions& options) {
    catch_interrupts();
    if (options.presentations > std::numeric_limits<std::uint32_t>::max())
        throw Failure("--presentations: must be below 2^32");
    if (options.calibrate + options.sensitivity + options.faults + options.ablations > 1)
        throw Failure("--calibrate, --sensitivity, --faults and --ablations: give one of them");
    if (!options.numbers.empty() && !options.sensitivity) throw Failure("--numbers: goes with --sensitivity");
    if (options.calibrate) return calibrate_scene(options);
    if (options.sensitivity) return ask_for_sensitivity(options);
    if (options.faults) return ask_for_faults(options);
    if (options.ablations) return ask_for_ablations(options);
    compare(options);
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
