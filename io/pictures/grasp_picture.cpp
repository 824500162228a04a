#include "afferent/io/pictures/grasp_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "afferent/io/pictures/figure.hpp"
#include "afferent/io/pictures/plot_data.hpp"

namespace afferent {
namespace {

// Where things stand, as fractions of the picture. Legends stand right of the panels, never on the data.
constexpr FigureSize grasp_size{960, 760};
constexpr double letter = 0.004;
constexpr double axis_title = 0.029;
constexpr double left = 0.082;
constexpr double right = 0.815;
constexpr double legend = 0.828;
constexpr double legend_text = 0.858;
constexpr double bottom = 0.072;
constexpr double between = 0.024;

// One panel: how high it is among the others, what is written along its axis, its own settings, and what it
// plots. Legends are listed apart from the curves: what matters most is drawn last and named first.
struct Panel {
    double height;
    std::string title;
    GnuplotScript settings;
    std::string curves;

    template <class... Parts>
    void plot(const Parts&... parts) {
        GnuplotScript clause;
        clause.line(parts...);
        curves +=
            (curves.empty() ? "plot " : ", \\\n     ") + clause.text().substr(0, clause.text().size() - 1);
    }
    void name(std::string_view style, std::string_view text) {
        plot("keyentry with ", style, " title ", gnuplot_text(text));
    }
};

std::string line_style(double width, std::string_view colour) {
    return "lines lw " + gnuplot_number(width) + " lc rgb '" + std::string(colour) + "'";
}

std::string band_style(std::string_view colour) {
    return "filledcurves fs solid 1 noborder lc rgb '" + std::string(colour) + "'";
}

// A curve; where it has too many points to be told apart, its range and its mean over a few pixels.
void plot_curve(Panel& panel, std::string& data, const std::string& name, const std::vector<double>& x,
                const std::vector<double>& y, std::string_view range_colour, const std::string& line) {
    if (!wants_envelope(y.size())) {
        data += curve_data(name, x, y);
        return panel.plot(name, " with ", line, " notitle");
    }
    data += envelope_data(name, x, y);
    panel.plot(name, " using 1:2:3 with ", band_style(range_colour), " notitle");
    panel.plot(name, " using 1:4 with ", line, " notitle");
}

// The distance of round tics, so that there are three to six up to the highest value.
double tic_distance(double highest) {
    const double power = std::pow(10, std::floor(std::log10(highest)));
    const double leading = highest / power;
    return power * (leading >= 6 ? 2 : leading >= 3 ? 1 : leading >= 1.5 ? 0.5 : 0.25);
}

double highest_of(const std::vector<double>& values) {
    double highest = 0;
    for (const double value : values)
        if (value > highest) highest = value;  // passes over NaN
    return highest;
}

// From zero to a tic, never empty.
void scale_axis(GnuplotScript& settings, double highest) {
    const double distance = tic_distance(highest > 0 ? highest : 1);
    settings.line("set yrange [0:", distance * std::max(1.0, std::ceil(highest / distance - 1e-9)), "]");
    settings.line("set ytics ", distance);
}

Panel force_panel(const GraspPicture& picture, std::string& data) {
    const auto dashed = line_style(1.2, colour::vermilion) + " dt (8,5)";
    const auto true_line = line_style(1.4, colour::axis);
    const auto estimate_line = line_style(1.2, colour::blue);
    const auto band = band_style(colour::pale_blue);
    const auto range = band_style(colour::half_blue);
    const bool has_true = !picture.true_force_n.empty();
    const bool has_estimate = !picture.estimate_n.empty();
    const bool has_band = has_estimate && !picture.sigma_n.empty();
    std::vector<double> half_n;
    for (const double sigma_n : picture.sigma_n) half_n.push_back(2 * sigma_n);

    Panel panel{.height = 1.45, .title = "Grip force (N)", .settings = {}, .curves = {}};
    double highest = std::max(highest_of(picture.true_force_n), highest_of(picture.estimate_n));
    // The whole band, but where as good as nothing is known: before the first spikes it is as high as can be.
    for (std::size_t i = 0; has_band && i < half_n.size(); ++i)
        if (half_n[i] < picture.estimate_n[i]) highest = std::max(highest, picture.estimate_n[i] + half_n[i]);
    for (const auto& level : picture.levels) highest = std::max(highest, 1.02 * level.force_n);
    scale_axis(panel.settings, highest);

    if (has_band) {
        data += band_data("$sigma", picture.time_s, picture.estimate_n, half_n);
        panel.plot("$sigma using 1:2:3 with ", band, " notitle");
    }
    for (const auto& level : picture.levels) panel.plot(level.force_n, " with ", dashed, " notitle");
    if (has_estimate) {
        plot_curve(panel, data, "$estimate", picture.time_s, picture.estimate_n, colour::half_blue,
                   estimate_line);
    }
    if (has_true) {
        data += curve_data("$true_force", picture.time_s, picture.true_force_n);
        panel.plot("$true_force with ", true_line, " notitle");
    }
    if (has_true) panel.name(true_line, "true force");
    const bool has_range = has_estimate && wants_envelope(picture.estimate_n.size());
    if (has_estimate) panel.name(estimate_line, has_range ? "estimate, mean" : "estimate");
    if (has_range) panel.name(range, "its range");
    if (has_band) panel.name(band, "± 2 σ");
    for (const auto& level : picture.levels) panel.name(dashed, level.name);
    return panel;
}

// The colours of the patches, in their order.
std::vector<std::string_view> hues_of(const std::vector<GraspPicture::Patch>& patches) {
    std::array<std::size_t, 2> of_kind{};
    std::vector<std::string_view> hues;
    for (const auto& patch : patches) {
        const auto& kind = patch.transient ? colour::transient : colour::sustained;
        hues.push_back(kind[of_kind[patch.transient ? 1 : 0]++ % kind.size()]);
    }
    return hues;
}

// A name as it fits beside a panel; the rest of a long one is left out.
std::string in_legend(const std::string& name) {
    constexpr int most_letters = 22;
    int letters = 0;
    std::size_t cut = 0;
    for (std::size_t i = 0; i < name.size(); ++i) {
        if ((static_cast<unsigned char>(name[i]) & 0xC0) == 0x80) continue;  // goes on with a letter of UTF-8
        if (letters == most_letters - 1) cut = i;
        ++letters;
    }
    return letters <= most_letters ? name : name.substr(0, cut) + "…";
}

Panel part_panel(const GraspPicture& picture, std::string& data) {
    // Each name of a legend takes a line of the panel.
    constexpr std::size_t most_names = 8;
    const auto hues = hues_of(picture.patches);
    const auto true_line = line_style(1, colour::axis) + " dt (3,3)";
    Panel panel{.height = 1.1, .title = "Force on parts (N)", .settings = {}, .curves = {}};
    double highest = 0;
    for (const auto& part : picture.parts)
        highest = std::max({highest, highest_of(part.true_force_n), highest_of(part.estimate_n)});
    scale_axis(panel.settings, highest);
    for (std::size_t i = 0; i < picture.parts.size(); ++i) {
        const auto& [name, patch, true_force_n, estimate_n] = picture.parts[i];
        const std::string number = std::to_string(i);
        data += curve_data("$true_part_" + number, picture.time_s, true_force_n);
        plot_curve(panel, data, "$part_" + number, picture.time_s, estimate_n, colour::faint,
                   line_style(1.1, hues[patch]));
        panel.plot("$true_part_", number, " with ", true_line, " notitle");
        if (picture.parts.size() <= most_names) panel.name(line_style(1.1, hues[patch]), in_legend(name));
    }
    panel.name(true_line, "true forces");
    return panel;
}

// Where the patches' names stand, as shares of the panel's height from its top: beside their rows, and
// a line of text apart, above `lowest`. A patch has none where there are more than fit.
std::vector<std::optional<double>> places_of_names(const GraspPicture& picture, double rows, double lowest) {
    constexpr double line = 0.11;
    constexpr double highest = 0.04;
    const bool all = static_cast<double>(picture.patches.size() - 1) * line <= lowest - highest;
    std::vector<std::optional<double>> places;
    double next = all ? highest : 0;
    for (const auto& [name, first, elements, transient] : picture.patches) {
        const double middle = std::min((first + elements / 2.0) / rows, lowest);
        places.push_back(all || middle >= next ? std::optional(std::max(middle, next)) : std::nullopt);
        if (places.back()) next = *places.back() + line;
    }
    for (auto place = places.rbegin(); all && place != places.rend(); ++place) {
        *place = std::min(**place, lowest);
        lowest = **place - line;
    }
    return places;
}

Panel spike_panel(const GraspPicture& picture, std::string& data) {
    Address rows = 0;
    for (const auto& patch : picture.patches) rows = std::max(rows, patch.first + patch.elements);
    if (!picture.density) data += spike_data("$spikes", picture.events, picture.begin_s, picture.end_s, rows);

    // The first address is on top. A mark is a little shorter than its row, but never too short to be seen.
    Panel panel{.height = 1.1, .title = "Address", .settings = {}, .curves = {}};
    panel.settings.line("set yrange [", rows - 0.5, ":-0.5]");
    panel.settings.line("set ytics ", rows <= 12 ? 1 : tic_distance(rows));
    const double half_mark = std::max(0.38, rows / 400.0);
    const auto places = places_of_names(picture, rows, picture.density ? 0.84 : 0.96);
    std::vector<SpikeDensity::Hue> hues;
    for (const std::string_view hue : hues_of(picture.patches)) {
        const auto& [name, first, elements, transient] = picture.patches[hues.size()];
        if (const auto place = places[hues.size()])
            panel.settings.line("set label ", gnuplot_text(in_legend(name)), " at screen ", legend_text,
                                ", graph ", 1 - *place, " left noenhanced textcolor rgb '", hue, "'");
        hues.push_back({first, elements, hue});
        if (first > 0)
            panel.settings.line("set arrow from graph 0, first ", first - 0.5, " to graph 1, first ",
                                first - 0.5, " nohead ", picture.density ? "front" : "back",
                                " lw 0.6 lc rgb '", colour::faint, "'");
        if (!picture.density)
            panel.plot("$spikes using ($2 >= ", first, " && $2 < ", first + elements, " ? $1 : NaN):($2 - ",
                       half_mark, "):(0):(", 2 * half_mark, ") with vectors nohead lw 0.6 lc rgb '", hue,
                       "' notitle");
    }
    if (!picture.density) return panel;
    data += picture.density->data("$spikes", hues);
    panel.plot("$spikes using 1:2:3:4:5 with rgbimage notitle");
    panel.settings.line("set label 'full colour: ", std::round(picture.density->peak_hz()), " Hz' at screen ",
                        legend_text, ", graph 0.03 left textcolor rgb '", colour::axis, "'");
    return panel;
}

Panel rate_panel(const GraspPicture& picture, std::string& data) {
    Panel panel{.height = 0.75, .title = "Spike rate (Hz)", .settings = {}, .curves = {}};
    scale_axis(panel.settings, highest_of(picture.rate_hz));
    plot_curve(panel, data, "$rate", picture.time_s, picture.rate_hz, colour::faint,
               line_style(1, colour::axis));
    panel.name(line_style(1.4, colour::axis), "mean of neurons");
    if (wants_envelope(picture.rate_hz.size())) panel.name(band_style(colour::faint), "its range");
    return panel;
}

Panel gain_panel(const GraspPicture& picture, std::string& data) {
    const auto emg_line = line_style(1, colour::faint);
    const auto command_line = line_style(1, colour::sky);
    const auto gain_line = line_style(1.2, colour::vermilion);
    // Without a user both are 0 for good.
    const auto is_active = [](const std::vector<double>& values) {
        return std::ranges::any_of(values, [](double value) { return value != 0; });
    };
    const bool has_emg = is_active(picture.emg);
    const bool has_command = is_active(picture.command);
    Panel panel{.height = 0.95,
                .title = std::string("Gain") + (has_emg ? ", EMG" : "") + (has_command ? ", command" : ""),
                .settings = {},
                .curves = {}};
    const bool opens = std::ranges::any_of(picture.command, [](double command) { return command < 0; });
    panel.settings.line("set yrange [", opens ? -1.0 : 0.0, ":1.05]");
    panel.settings.line("set ytics 0.5");

    if (has_emg) {
        data += curve_data("$emg", picture.time_s, picture.emg);
        panel.plot("$emg with ", emg_line, " notitle");
    }
    if (has_command) {
        data += curve_data("$command", picture.time_s, picture.command);
        panel.plot("$command with ", command_line, " notitle");
    }
    plot_curve(panel, data, "$gain", picture.time_s, picture.gain, colour::half_vermilion, gain_line);
    panel.name(gain_line, "EMG gain");
    if (has_emg) panel.name(emg_line, "closing EMG");
    if (has_command) panel.name(command_line, opens ? "motor, < 0 opens" : "motor command");
    return panel;
}

// A run ends with its last sample, a little before the tic at its duration.
double axis_end(double begin_s, double end_s) {
    const double distance = tic_distance(end_s - begin_s);
    const double tic = distance * std::ceil(end_s / distance);
    return tic - end_s < 0.01 * (end_s - begin_s) ? tic : end_s;
}

// Above one another, over one time axis.
GnuplotScript stacked(const GraspPicture& picture, const std::vector<Panel>& panels) {
    double height = 0;
    for (const Panel& panel : panels) height += panel.height;
    double top = picture.title.empty() ? 0.985 : 0.945;
    const double unit = (top - bottom - between * static_cast<double>(panels.size() - 1)) / height;

    GnuplotScript body;
    body.line("reset");
    body.line("set multiplot");
    body.line("set samples 2");  // the levels are straight
    body.line("set lmargin at screen ", left);
    body.line("set rmargin at screen ", right);
    body.line("set xrange [", picture.begin_s, ':', axis_end(picture.begin_s, picture.end_s), ']');
    body.line("set border 2 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set tics nomirror out scale 0.5 textcolor rgb '", colour::axis, "'");
    body.line("set grid xtics back lt 1 lw 0.6 lc rgb '", colour::grid, "'");
    body.line("set xtics scale 0");
    body.line("set format x ''");
    const std::string in_axis_colour = " textcolor rgb '" + std::string(colour::axis) + "'";
    if (!picture.title.empty())
        body.line("set label ", gnuplot_text(picture.title), " at screen ", left,
                  ", 0.973 left noenhanced font title_font", in_axis_colour);
    for (const Panel& panel : panels) {
        const double panel_bottom = top - unit * panel.height;
        if (&panel == &panels.back()) {
            body.line("set border 3");
            body.line("set xtics scale 0.5");
            body.line("set format x '%g'");
            body.line("set label 'Time (s)' at screen ", std::midpoint(left, right), ", 0.02 center",
                      in_axis_colour);
        }
        body.line("set tmargin at screen ", top);
        body.line("set bmargin at screen ", panel_bottom);
        body.line("set label ", gnuplot_text(panel.title), " at screen ", axis_title, ',',
                  std::midpoint(top, panel_bottom), " center rotate", in_axis_colour);
        if (panels.size() > 1)
            put_letter(body, static_cast<std::size_t>(&panel - panels.data()), letter, top - 0.008);
        body.line("set key at screen ", legend, ',', top,
                  " left top Left reverse samplen 1.4 spacing 1.15 noenhanced", in_axis_colour);
        body.append(panel.settings);
        body.line(panel.curves);
        body.line("unset label");
        body.line("unset arrow");
        top = panel_bottom - between;
    }
    body.line("unset multiplot");
    return body;
}

}  // namespace

Drawing draw(const GraspPicture& picture, const std::filesystem::path& stem) {
    std::string data;
    std::vector<Panel> panels;
    if (!picture.true_force_n.empty() || !picture.estimate_n.empty())
        panels.push_back(force_panel(picture, data));
    if (!picture.parts.empty()) panels.push_back(part_panel(picture, data));
    if (!picture.patches.empty()) panels.push_back(spike_panel(picture, data));
    if (!picture.rate_hz.empty()) panels.push_back(rate_panel(picture, data));
    if (!picture.gain.empty()) panels.push_back(gain_panel(picture, data));
    if (panels.empty()) return {Drawn::failed, "there is nothing to draw"};
    return draw_figure(stem, grasp_size, data, stacked(picture, panels));
}

}  // namespace afferent
