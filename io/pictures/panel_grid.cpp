#include "afferent/io/pictures/panel_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

#include "afferent/io/pictures/figure.hpp"
#include "afferent/io/pictures/plot_data.hpp"

namespace afferent {
namespace {

// The names of curves and levels in the order in which they first stand there: one legend for all panels.
struct Legend {
    std::vector<std::string> curves;
    std::vector<bool> dashed;
    std::vector<std::string> levels;

    explicit Legend(const PanelGrid& picture) {
        for (const auto& panel : picture.panels) {
            for (const auto& curve : panel.curves) {
                if (std::ranges::find(curves, curve.name) != curves.end()) continue;
                curves.push_back(curve.name);
                dashed.push_back(curve.dashed);
            }
            for (const auto& level : panel.levels)
                if (std::ranges::find(levels, level.name) == levels.end()) levels.push_back(level.name);
        }
    }

    std::size_t place_of(const std::string& curve) const {
        return static_cast<std::size_t>(std::ranges::find(curves, curve) - curves.begin());
    }
    std::string_view hue_of(const std::string& curve) const {
        return colour::series[place_of(curve) % colour::series.size()];
    }
};

struct Extent {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    void add(std::span<const double> values) {
        for (const double value : values) {
            if (!std::isfinite(value)) continue;
            low = std::min(low, value);
            high = std::max(high, value);
        }
    }
};

// An axis of all that a panel shows, with room above; never empty.
std::pair<double, double> y_range_of(const PanelGrid::Panel& panel) {
    if (panel.y_range) return *panel.y_range;
    Extent extent;
    for (const auto& curve : panel.curves) {
        extent.add(curve.y);
        extent.add(curve.low);
        extent.add(curve.high);
    }
    for (const auto& level : panel.levels)
        if (!level.upright) extent.add(std::span(&level.value, 1));
    if (extent.low > extent.high) return {0, 1};
    const double low = std::min(0.0, 1.08 * extent.low);
    const double high = 1.08 * std::max(0.0, extent.high);
    return {low, high > low ? high : low + 1};
}

void put_x_range(GnuplotScript& body, const PanelGrid::Panel& panel, double most_tics) {
    Extent extent;
    for (const auto& curve : panel.curves) extent.add(curve.x);
    if (panel.logarithmic_x) body.line("set logscale x");
    body.line("set xtics autofreq");
    const auto [from, to] = panel.x_range.value_or(std::pair(extent.low, extent.high));
    // gnuplot's own run into each other where a panel is narrow.
    if (!panel.logarithmic_x && from < to)
        body.line("set xtics ", round_below(2.5 * (to - from) / most_tics));
    if (panel.x_range) return body.line("set xrange [", from, ':', to, ']');
    if (!(extent.low < extent.high)) return body.line("set xrange [*:*]");
    // Marked points are not cut by the axis.
    const bool marked = std::ranges::any_of(panel.curves, &PanelGrid::Curve::marked);
    const double margin = marked ? 0.03 : 0;
    if (panel.logarithmic_x && extent.low > 0) {
        const double factor = std::pow(extent.high / extent.low, margin);
        return body.line("set xrange [", extent.low / factor, ':', extent.high * factor, ']');
    }
    const double wide = extent.high - extent.low;
    body.line("set xrange [", extent.low - margin * wide, ':', extent.high + margin * wide, ']');
}

std::string level_style() { return "lines lw 1 dt (6,4) lc rgb '" + std::string(colour::axis) + "'"; }

std::string curve_style(bool marked, bool dashed, std::size_t place, std::string_view hue) {
    constexpr int shapes[] = {7, 5, 9, 13, 11, 15};
    return std::string(marked ? "linespoints" : "lines") + " lw 1.4" + (dashed ? " dt (5,3)" : "") +
           (marked ? " ps 0.6 pt " + std::to_string(shapes[place % std::size(shapes)]) : "") + " lc rgb '" +
           std::string(hue) + "'";
}

void put_panel(GnuplotScript& body, GnuplotScript& data, const PanelGrid::Panel& panel, std::size_t number,
               const Legend& named, double most_tics) {
    const std::string in_axis_colour = " textcolor rgb '" + std::string(colour::axis) + "'";
    body.line("unset logscale");
    body.line("unset arrow");
    const auto [low, high] = y_range_of(panel);
    put_x_range(body, panel, most_tics);
    body.line("set yrange [", low, ':', high, ']');
    for (const auto& [what, text] : {std::pair("title", &panel.title), std::pair("xlabel", &panel.x_title),
                                     std::pair("ylabel", &panel.y_title)})
        body.line("set ", what, ' ', gnuplot_text(*text), " noenhanced", in_axis_colour);
    std::string clauses;
    const auto plot = [&clauses](const auto&... parts) {
        GnuplotScript clause;
        clause.line(parts...);
        clauses +=
            (clauses.empty() ? "plot " : ", \\\n     ") + clause.text().substr(0, clause.text().size() - 1);
    };
    for (const auto& level : panel.levels) {
        if (level.upright)
            body.line("set arrow from ", level.value, ", graph 0 to ", level.value,
                      ", graph 1 nohead lw 1 dt (6,4) lc rgb '", colour::axis, "'");
        else
            plot(level.value, " with ", level_style(), " notitle");
    }
    for (std::size_t i = 0; i < panel.curves.size(); ++i) {
        const auto& curve = panel.curves[i];
        const std::string name = "$p" + std::to_string(number) + '_' + std::to_string(i);
        const std::string_view hue = named.hue_of(curve.name);
        if (!curve.low.empty()) {
            data.line(name, "_band << EOD");
            for (std::size_t k = 0; k < curve.low.size(); ++k)
                data.line(curve.x[k], ' ', curve.low[k], ' ', curve.high[k]);
            data.line("EOD");
            plot(name, "_band using 1:2:3 with filledcurves fs transparent solid 0.2 noborder lc rgb '", hue,
                 "' notitle");
        }
        data.line(curve_data(name, curve.x, curve.y));
        plot(name, " with ", curve_style(curve.marked, curve.dashed, named.place_of(curve.name), hue),
             " notitle");
    }
    body.line(clauses);
}

// In the space above the panels: a plot of nothing but its names.
void put_legend(GnuplotScript& body, const PanelGrid& picture, const Legend& named, double lowest,
                double highest) {
    body.line("set lmargin at screen 0.02");
    body.line("set rmargin at screen 0.98");
    body.line("set bmargin at screen ", lowest);
    body.line("set tmargin at screen ", highest);
    body.line("unset border");
    body.line("unset tics");
    body.line("unset title");
    body.line("unset xlabel");
    body.line("unset ylabel");
    body.line("unset arrow");
    body.line("unset logscale");
    body.line("set xrange [0:1]");
    body.line("set yrange [0:1]");
    body.line("set key at screen 0.5, screen ", highest,
              " center top horizontal maxrows 2 samplen 2 noenhanced textcolor rgb '", colour::axis, "'");
    bool marked = false;
    for (const auto& panel : picture.panels)
        marked = marked || std::ranges::any_of(panel.curves, &PanelGrid::Curve::marked);
    std::string clauses;
    for (std::size_t i = 0; i < named.curves.size(); ++i)
        clauses +=
            (clauses.empty() ? "plot " : ", ") +
            ("keyentry with " + curve_style(marked, named.dashed[i], i, named.hue_of(named.curves[i])) +
             " title " + gnuplot_text(named.curves[i]));
    for (const std::string& level : named.levels)
        clauses += (clauses.empty() ? "plot " : ", ") +
                   ("keyentry with " + level_style() + " title " + gnuplot_text(level));
    body.line(clauses, ", NaN notitle");
}

// In pixels from the top of the picture: of the panels of a row, and of what is below them.
struct Row {
    double top;
    double bottom;
    double end;
};

std::vector<Row> rows_of(const PanelGrid& picture, std::size_t columns, double begin) {
    std::vector<Row> rows;
    for (std::size_t first = 0; first < picture.panels.size(); first += columns) {
        const auto of_row =
            std::span(picture.panels).subspan(first, std::min(columns, picture.panels.size() - first));
        const bool titled = std::ranges::any_of(of_row, [](const auto& p) { return !p.title.empty(); });
        const bool named = std::ranges::any_of(of_row, [](const auto& p) { return !p.x_title.empty(); });
        const double top = begin + (titled ? 28 : 12);
        const double lowest = top + picture.panel_height;
        begin = lowest + (named ? 48 : 26);
        rows.push_back({top, lowest, begin});
    }
    return rows;
}

}  // namespace

Drawing draw(const PanelGrid& picture, const std::filesystem::path& stem) {
    if (picture.panels.empty() || picture.columns == 0) return {Drawn::failed, "there is nothing to draw"};
    const std::size_t columns = std::min(picture.columns, picture.panels.size());
    const double width = columns == 1 ? 760 : columns == 2 ? 960 : 1180;
    // In pixels: the title and the legend above the panels, and what each panel has beside it.
    constexpr double head = 62;
    constexpr double title_line = 30;
    constexpr double beside_left = 66;
    constexpr double beside_right = 16;
    constexpr double tic_width = 45;
    const std::vector<Row> rows = rows_of(picture, columns, head);
    const double height = rows.back().end;

    const Legend named(picture);
    GnuplotScript data;
    GnuplotScript body;
    body.line("reset");
    body.line("set multiplot");
    body.line("set label ", gnuplot_text(picture.title), " at screen 0.5, ", 1 - 0.5 * title_line / height,
              " center noenhanced font title_font textcolor rgb '", colour::axis, "'");
    body.line("set samples 2");  // the levels are straight
    body.line("unset key");
    body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set tics nomirror out scale 0.5,0.25 textcolor rgb '", colour::axis, "'");
    body.line("set grid xtics ytics back lt 1 lw 0.6 lc rgb '", colour::grid, "'");
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < picture.panels.size(); ++i) {
        if (picture.panels[i].curves.empty()) continue;
        const double column = static_cast<double>(i % columns);
        const double panel_width = width / static_cast<double>(columns);
        body.line("set lmargin at screen ", (column * panel_width + beside_left) / width);
        body.line("set rmargin at screen ", ((column + 1) * panel_width - beside_right) / width);
        body.line("set tmargin at screen ", 1 - rows[i / columns].top / height);
        body.line("set bmargin at screen ", 1 - rows[i / columns].bottom / height);
        if (picture.panels.size() > 1)
            put_letter(body, drawn++, (column * panel_width + 8) / width,
                       1 - (rows[i / columns].top - 14) / height);
        put_panel(body, data, picture.panels[i], i, named,
                  (panel_width - beside_left - beside_right) / tic_width);
        body.line("unset label");
    }
    put_legend(body, picture, named, 1 - head / height, 1 - title_line / height);
    body.line("unset multiplot");
    return draw_figure(stem, {static_cast<int>(width), static_cast<int>(height)}, data.text(), body);
}

}  // namespace afferent
