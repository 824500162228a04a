// afferent inspect: what a table is taken for, a picture of it, and a scene that runs on it.
#include <algorithm>
#include <charconv>
#include <fstream>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/progress.hpp"
#include "afferent/apps/scene_paths.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/apps/table_choice.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/io/pictures/gnuplot.hpp"
#include "afferent/scene/scene_table.hpp"
#include "afferent/studies/inspect_report.hpp"

namespace afferent {
namespace {

namespace fs = std::filesystem;

struct InspectOptions {
    std::string table;
    TableChoice choice;
    std::string calibration;
    std::optional<double> newtons_per_volt;
    std::optional<double> reference_v;
    std::string scene;
    std::string out;
    bool json = false;
};

// "0:0,1.2:0.5": points of volts, or counts, and newtons.
std::vector<Calibration::Point> calibration_points(const std::string& text) {
    std::vector<Calibration::Point> points;
    const char* at = text.data();
    const char* const end = at + text.size();
    const auto number = [&](double& value) {
        const auto [stop, failure] = std::from_chars(at, end, value);
        at = stop;
        return failure == std::errc() && std::isfinite(value);
    };
    const auto refuse = [&]() -> void {
        throw Failure(
            "--calibration: must be points such as 0:0,1.2:0.5,3:4 (volts or counts, and newtons), in rising "
            "order, is " +
            text);
    };
    while (at != end) {
        Calibration::Point point{};
        if (!points.empty() && *at++ != ',') refuse();
        if (!number(point.counts) || at == end || *at++ != ':' || !number(point.force_n)) refuse();
        if (!points.empty() && point.counts <= points.back().counts) refuse();
        points.push_back(point);
    }
    if (points.size() < 2) refuse();
    return points;
}

InspectionOptions inspection_options(const InspectOptions& options) {
    scene::Table table;
    options.choice.apply(table);
    InspectionOptions inspection{.table = table_options(table), .unit = table.unit};
    if (!options.calibration.empty()) inspection.calibration = calibration_points(options.calibration);
    inspection.newtons_per_volt = options.newtons_per_volt;
    inspection.reference_v = options.reference_v;
    return inspection;
}

TableInspection read_and_inspect(const InspectOptions& options) {
    Progress progress("reading the table");
    InspectionOptions inspection = inspection_options(options);
    inspection.progress = [&](double fraction) { progress.at(fraction); };
    return value_or_fail(inspect_table(options.table, inspection));
}

void draw_picture(const TableInspection& found, const Summary& summary, const std::string& folder) {
    ResultsFolder results =
        value_or_fail(ResultsFolder::create(folder, {"table.svg", "table.png", "inspection.json"}));
    const Drawing drawing = draw(picture_of(found), results.unfinished() / "table");
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "no picture: gnuplot is not installed\n";
    if (drawing.outcome == Drawn::failed)
        std::cerr << "no picture: gnuplot failed: " << drawing.message << '\n';
    write(summary, results.unfinished() / "inspection.json");
    value_or_fail(results.put_in_place());
}

void name_table(Scene& scene, const std::string& path) {
    force_table(scene.source)->path = path;
    if (scene.hand.emg_table) scene.hand.emg_table->path = path;
}

std::string scene_file_text(const InspectOptions& options, const TableInspection& found, const Scene& scene) {
    std::string text = "# " + fs::path(options.table).filename().string() + ", by: afferent inspect\n";
    for (const std::string& sentence : found.assumptions) text += "# Assumed: " + sentence + '\n';
    return text + scene.text(Scene::TextLayout::field_a_line);
}

void inspect_command_line(const InspectOptions& options) {
    TableInspection found = read_and_inspect(options);
    const std::string scene_file = options.scene.empty() ? "scene.txtpb" : options.scene;
    if (found.scene) name_table(*found.scene, path_from(fs::path(scene_file).parent_path(), options.table));
    const Scene* const scene = found.scene ? &*found.scene : nullptr;
    const Summary summary = summary_of(found);
    if (!options.out.empty()) draw_picture(found, summary, options.out);
    if (options.json)
        print(summary, true);
    else
        print(found, std::cout);
    if (!scene) {
        if (options.json && options.scene.empty()) return;
        throw Failure(options.table + ": no scene: " + found.why_no_scene);
    }
    const std::string text = scene_file_text(options, found, *scene);
    if (!options.scene.empty()) {
        std::ofstream out(options.scene);
        out << text;
        out.close();
        if (!out) throw Failure(options.scene + ": cannot be written");
    }
    if (options.json) return;
    if (options.scene.empty())
        std::cout << "A scene for it; --scene FILE writes it:\n\n" << text;
    else
        std::cout << "The scene is written to " << options.scene << ". Next:\n  afferent run "
                  << options.scene << " --out out/" << (scene->name.empty() ? "table" : scene->name) << '\n';
    if (!options.out.empty()) std::cout << "The picture is in " << options.out << '\n';
}

}  // namespace

Command inspect_command() {
    const auto options = std::make_shared<InspectOptions>();
    std::vector<Option> all{
        positional(
            "TABLE", options->table,
            "A table of forces, and of EMG, in text (which gzip may have compressed), HDF5, MAT, NPZ or NPY")
            .required()};
    std::ranges::move(options->choice.options(), std::back_inserter(all));
    std::ranges::move(
        std::vector<Option>{
            option("--calibration", options->calibration,
                   "From volts, or counts, to newtons: points such as 0:0,1.2:0.5,3:4"),
            option("--newtons-per-volt", options->newtons_per_volt, "The same for sensors that are linear")
                .positive()
                .excludes("--calibration"),
            option("--reference-v", options->reference_v, "The voltage at which sensors read the most")
                .positive(),
            option("--scene", options->scene, "File for a scene that runs on the table"),
            option("--out", options->out, "Folder for table.svg, table.png and inspection.json"),
            flag("--json", options->json, "Print all of it as JSON"),
        },
        std::back_inserter(all));
    return {
        .name = "inspect",
        .help = "Say what a table is taken for, draw it, and write a scene that runs on it",
        .footer =
            "Example:\n  afferent inspect fingers.csv --scene fingers.txtpb --out out/look\n"
            "  afferent run fingers.txtpb --out out/fingers\n\n"
            "docs/tables.md has the rules by which tables are understood.",
        .options = std::move(all),
        .run = [options] { inspect_command_line(*options); },
    };
}

}  // namespace afferent
