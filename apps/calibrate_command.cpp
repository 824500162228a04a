// afferent calibrate: fits a scene to recorded forces, and to the spikes recorded beside them.
#include <cmath>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <memory>

#include "afferent/apps/commands.hpp"
#include "afferent/apps/event_file.hpp"
#include "afferent/apps/failure.hpp"
#include "afferent/apps/scene_options.hpp"
#include "afferent/apps/scene_paths.hpp"
#include "afferent/apps/summary.hpp"
#include "afferent/io/files/results_folder.hpp"
#include "afferent/io/pictures/scatter_picture.hpp"
#include "afferent/scene/scene_table.hpp"
#include "afferent/studies/calibrate.hpp"

namespace afferent {
namespace {

struct CalibrateOptions {
    SceneOptions scene;
    std::string from;
    std::string events;
    std::string out;
    bool json = false;
};

constexpr std::size_t most_points_drawn = 400;  // of a patch

void add_fit(Summary& summary, const std::optional<DriveFit>& fit) {
    summary["intervals"] = fit ? fit->samples : std::size_t{0};
    summary["gain_mv_per_n"] = fit ? Summary(fit->gain_mv_per_n) : Summary();
    summary["bias_mv"] = fit ? Summary(fit->bias_mv) : Summary();
    summary["residual_mv"] = fit ? Summary(fit->residual_mv) : Summary();
    summary["residual_n"] = fit ? Summary(fit->residual_mv / fit->gain_mv_per_n) : Summary();
}

Summary summary_of(const SceneFit& fit) {
    Summary summary{{"scene", fit.scene.name}};
    for (const SceneFit::Element& element : fit.elements)
        summary["shares"].push_back({{"patch", element.patch},
                                     {"element", element.element},
                                     {"share", or_null(element.share)},
                                     {"residual_n", or_null(element.share_residual_n)}});
    for (const SceneFit::Element& element : fit.elements)
        if (element.dead) summary["dead"].push_back({{"patch", element.patch}, {"element", element.element}});
    if (fit.shares_wander)
        summary["uncertainty"] = {{"share", fit.shares_wander->part},
                                  {"share_time_s", fit.shares_wander->time_s}};
    if (fit.gain_spread) summary["uncertainty"]["gain"] = *fit.gain_spread;
    for (const SceneFit::Patch& patch : fit.patches) {
        Summary told{{"patch", fit.scene.patches[patch.index].name}};
        add_fit(told, patch.fit);
        for (const SceneFit::Afferent& afferent : patch.afferents) {
            Summary one{{"address", afferent.address}};
            add_fit(one, afferent.fit);
            told["afferents"].push_back(std::move(one));
        }
        summary["patches"].push_back(std::move(told));
    }
    if (fit.motions) {
        const auto& motion = fit.motions->force.motion;
        summary["motions"] = {{"hold_speed_n_per_s", motion[0].speed_n_per_s},
                              {"hold_drift_n2_per_s", motion[0].drift_n2_per_s},
                              {"movement_speed_n_per_s", motion[1].speed_n_per_s},
                              {"contact_speed_n_per_s", motion[2].speed_n_per_s},
                              {"log_density_before", fit.motions->score_before},
                              {"log_density", fit.motions->score}};
        summary["motions"]["written"] = is_filter(fit.scene.decoder);
    }
    return summary;
}

// Thinned out, so that a picture can show the points.
ScatterPicture drive_picture(const SceneFit& fit) {
    ScatterPicture picture{.title = "Drive of each interspike interval, without the bias",
                           .x_title = "Force felt in that interval (N)",
                           .y_title = "Drive − bias (mV)",
                           .series = {}};
    for (const SceneFit::Patch& patch : fit.patches) {
        if (!patch.fit) continue;
        const std::string& name = fit.scene.patches[patch.index].name;
        ScatterPicture::Series points{.name = name, .points = {}, .joined = false, .kind = patch.index};
        double lowest_n = std::numeric_limits<double>::infinity();
        double highest_n = 0;
        const std::size_t stride = patch.samples.size() / most_points_drawn + 1;
        for (std::size_t i = 0; i < patch.samples.size(); i += stride) {
            const auto& [force_n, drive_mv] = patch.samples[i];
            points.points.push_back({force_n, drive_mv - patch.fit->bias_mv});
            if (force_n > 0) lowest_n = std::min(lowest_n, force_n);
            highest_n = std::max(highest_n, force_n);
        }
        ScatterPicture::Series line{
            .name = name + ", fitted", .points = {}, .joined = true, .kind = patch.index};
        for (const double force_n : {lowest_n, highest_n})
            line.points.push_back({force_n, patch.fit->gain_mv_per_n * force_n});
        picture.series.push_back(std::move(points));
        picture.series.push_back(std::move(line));
    }
    return picture;
}

ScatterPicture motion_picture(const MotionFit& fit) {
    ScatterPicture picture{.title = "What the filter expects of the next row's force",
                           .x_title = "Standard deviation expected (N)",
                           .y_title = "Error, root mean square (N)",
                           .series = {{.name = "samples, in groups", .points = {}, .joined = false},
                                      {.name = "as expected", .points = {}}}};
    for (const auto& [sigma_n, error_n] : fit.foretold)
        picture.series[0].points.push_back({sigma_n, error_n});
    for (const auto& end : {fit.foretold.front(), fit.foretold.back()})
        picture.series[1].points.push_back({end.sigma_n, end.sigma_n});
    return picture;
}

void draw_or_say_why(const ScatterPicture& picture, const std::filesystem::path& stem) {
    const Drawing drawing = draw(picture, stem);
    if (drawing.outcome == Drawn::no_gnuplot) std::cerr << "no picture: gnuplot is not installed\n";
    if (drawing.outcome == Drawn::failed)
        std::cerr << "no picture: gnuplot failed: " << drawing.message << '\n';
}

void write_results(const SceneFit& fit, const Summary& summary, const std::string& folder) {
    ResultsFolder results = value_or_fail(ResultsFolder::create(
        folder, {"scene.txtpb", "drive.svg", "drive.png", "motion.svg", "motion.png", "summary.json"}));
    const std::filesystem::path file = results.unfinished() / "scene.txtpb";
    Scene scene = fit.scene;
    move_inputs(scene, folder);
    std::ofstream out(file);
    out << "# " << scene.file << ", fitted by: afferent calibrate\n"
        << scene.text(Scene::TextLayout::field_a_line);
    out.close();
    if (!out) throw Failure(file.string() + ": cannot be written");
    if (!fit.patches.empty()) draw_or_say_why(drive_picture(fit), results.unfinished() / "drive");
    if (fit.motions) draw_or_say_why(motion_picture(*fit.motions), results.unfinished() / "motion");
    write(summary, results.unfinished() / "summary.json");
    value_or_fail(results.put_in_place());
}

// Rows of a list, under the names of the first.
void print_rows(const Summary::List& rows) {
    std::cout << std::setprecision(4) << std::right;
    for (const auto& [name, value] : rows.front().entries())
        if (value.list().empty()) std::cout << std::setw(16) << name;
    std::cout << '\n';
    for (const Summary& row : rows) {
        for (const auto& [name, value] : row.entries()) {
            if (!value.list().empty()) continue;
            std::cout << std::setw(16);
            if (const auto number = value.number())
                std::cout << *number;
            else
                std::cout << (value.text() ? *value.text() : "-");
        }
        std::cout << '\n';
    }
    std::cout << '\n';
}

// A sentence for each number that the scene's `uncertainty` is given, and for what is left out.
void print_uncertainty(const SceneFit& fit) {
    for (const SceneFit::Element& element : fit.elements)
        if (element.dead)
            std::cout << "Element " << element.element << " of " << element.patch
                      << " never changes: it is taken for dead, and left out (share 0).\n";
    if (fit.shares_wander) {
        std::cout << "The elements' shares wander by " << 100 * fit.shares_wander->part
                  << " % of themselves (uncertainty.share).\n";
        std::cout << "They do so within " << fit.shares_wander->time_s
                  << " s, when their autocorrelation has fallen to 1/e (uncertainty.share_time_s).\n";
    }
    if (fit.gain_spread)
        std::cout << "The gains of single afferents differ from their patches' by " << 100 * *fit.gain_spread
                  << " % (uncertainty.gain).\n";
    if (fit.shares_wander || fit.gain_spread) std::cout << '\n';
}

void print_for_people(const SceneFit& fit, const Summary& summary) {
    if (const Summary* shares = summary.find("shares")) {
        std::cout << "Shares of the grip force\n\n";
        print_rows(shares->list());
    }
    print_uncertainty(fit);
    if (const Summary* patches = summary.find("patches")) {
        std::cout << "Drive = gain · force + bias, by least squares over interspike intervals\n\n";
        print_rows(patches->list());
        for (const Summary& patch : patches->list()) {
            std::cout << *patch.find("patch")->text() << ", each afferent by itself\n\n";
            print_rows(patch.find("afferents")->list());
        }
    }
    if (const Summary* motions = summary.find("motions")) {
        std::cout << "How the force moves\n\n";
        print(*motions);
        std::cout << '\n';
    }
}

void calibrate_scene(const CalibrateOptions& options) {
    const Scene scene = options.scene.read();
    scene::Table from{.path = options.from};
    options.scene.of_table.apply(from);
    auto read = read_table(options.from, table_options(from));
    if (const auto* error = std::get_if<TableError>(&read)) throw Failure(error->message());
    EventSet events;
    if (!options.events.empty()) events = read_event_set(options.events);
    const SceneFit fit = value_or_fail(calibrate(scene, std::get<Table>(read), events.events, from.unit));
    const Summary summary = summary_of(fit);
    if (!options.out.empty()) write_results(fit, summary, options.out);
    if (options.json) return print(summary, true);
    print_for_people(fit, summary);
    if (options.out.empty())
        std::cout << "Nothing is written; --out DIR writes the fitted scene, its picture and summary.json\n";
    else
        std::cout << "Written to " << options.out << '\n';
}

}  // namespace

Command calibrate_command() {
    const auto options = std::make_shared<CalibrateOptions>();
    options->scene.choice_is_of_scene = false;
    return {
        .name = "calibrate",
        .help = "Fit gains, biases, shares and the filter's noise to recorded forces and spikes",
        .footer =
            "Example:\n  afferent calibrate examples/recorded.txtpb --from examples/data/grip.csv --out "
            "out/fitted",
        .options = options->scene.followed_by({
            option("--from", options->from,
                   "A table of forces: the grip force in newtons, or a column for each element, in newtons, "
                   "counts or volts")
                .required(),
            option("--events", options->events,
                   "The spikes recorded beside it: a recording, or what afferent convert writes"),
            option("--out", options->out, "Folder for scene.txtpb, its pictures and summary.json"),
            flag("--json", options->json, "Print the fit as JSON"),
        }),
        .run = [options] { calibrate_scene(*options); },
    };
}

}  // namespace afferent
