#include "afferent/studies/calibrate_report.hpp"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <string>

namespace afferent {
namespace {

constexpr std::size_t most_points_drawn = 400;  // of a patch

void add_fit(Summary& summary, const std::optional<DriveFit>& fit) {
    summary["intervals"] = fit ? fit->samples : std::size_t{0};
    summary["gain_mv_per_n"] = fit ? Summary(fit->gain_mv_per_n) : Summary();
    summary["bias_mv"] = fit ? Summary(fit->bias_mv) : Summary();
    summary["residual_mv"] = fit ? Summary(fit->residual_mv) : Summary();
    summary["residual_n"] = fit ? Summary(fit->residual_mv / fit->gain_mv_per_n) : Summary();
}

// Rows of a list, under the names of the first.
void print_rows(const Summary::List& rows, std::ostream& out) {
    out << std::setprecision(4) << std::right;
    for (const auto& [name, value] : rows.front().entries())
        if (value.list().empty()) out << std::setw(16) << name;
    out << '\n';
    for (const Summary& row : rows) {
        for (const auto& [name, value] : row.entries()) {
            if (!value.list().empty()) continue;
            out << std::setw(16);
            if (const auto number = value.number())
                out << *number;
            else
                out << (value.text() ? *value.text() : "-");
        }
        out << '\n';
    }
    out << '\n';
}

// A sentence for each number that the scene's `uncertainty` is given, and for what is left out.
void print_uncertainty(const SceneFit& fit, std::ostream& out) {
    for (const SceneFit::Element& element : fit.elements)
        if (element.dead)
            out << "Element " << element.element << " of " << element.patch
                << " never changes: it is taken for dead, and left out (share 0).\n";
    if (fit.shares_wander) {
        out << "The elements' shares wander by " << 100 * fit.shares_wander->part
            << " % of themselves (uncertainty.share).\n";
        out << "They do so within " << fit.shares_wander->time_s
            << " s, when their autocorrelation has fallen to 1/e (uncertainty.share_time_s).\n";
    }
    if (fit.gain_spread)
        out << "The gains of single afferents differ from their patches' by " << 100 * *fit.gain_spread
            << " % (uncertainty.gain).\n";
    if (fit.shares_wander || fit.gain_spread) out << '\n';
}

void print_motions(const Summary& motions, std::ostream& out) {
    out << "How the force moves\n\n" << std::setprecision(6);
    for (const auto& [key, value] : motions.entries()) {
        const auto number = value.number();
        if (!number) continue;
        std::string name = key;
        std::ranges::replace(name, '_', ' ');
        out << "  " << std::left << std::setw(28) << name << *number << '\n';
    }
    const bool* written = std::get_if<bool>(&motions.find("written")->value());
    out << (written && *written ? "\n"
                                : "\nThese are the filter's noise, which the scene does not get: its decoder "
                                  "is another.\n\n");
}

}  // namespace

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
        Summary entry{{"patch", fit.scene.patches[patch.index].name}};
        add_fit(entry, patch.fit);
        for (const SceneFit::Afferent& afferent : patch.afferents) {
            Summary one{{"address", afferent.address}};
            add_fit(one, afferent.fit);
            entry["afferents"].push_back(std::move(one));
        }
        summary["patches"].push_back(std::move(entry));
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

void print(const SceneFit& fit, std::ostream& out) {
    const Summary summary = summary_of(fit);
    if (const Summary* shares = summary.find("shares")) {
        out << "Shares of the grip force\n\n";
        print_rows(shares->list(), out);
    }
    print_uncertainty(fit, out);
    if (const Summary* patches = summary.find("patches")) {
        out << "Drive = gain · force + bias, by least squares over interspike intervals\n\n";
        print_rows(patches->list(), out);
        for (const Summary& patch : patches->list()) {
            out << *patch.find("patch")->text() << ", each afferent by itself\n\n";
            print_rows(patch.find("afferents")->list(), out);
        }
    }
    if (fit.motions) print_motions(*summary.find("motions"), out);
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

}  // namespace afferent
