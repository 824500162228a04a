#include "afferent/io/pictures/bar_picture.hpp"

#include <algorithm>

#include "afferent/io/pictures/figure.hpp"

namespace afferent {
namespace {

// "send_on_delta" as people write it, on lines of one or two words.
std::string tic_text(const std::string& name) {
    std::string text = name;
    std::ranges::replace(text, '_', ' ');
    return text;
}

void put_axes(GnuplotScript& body, const BarPicture& picture, double highest) {
    const std::string in_axis_colour = " textcolor rgb '" + std::string(colour::axis) + "'";
    body.line("reset");
    body.line("set title ", gnuplot_text(picture.title), " noenhanced font title_font", in_axis_colour);
    body.line("set ylabel ", gnuplot_text(picture.y_title), " noenhanced", in_axis_colour);
    body.line("set border 3 lw 0.8 lc rgb '", colour::axis, "'");
    body.line("set tics nomirror out scale 0.5,0", in_axis_colour);
    body.line("set grid ytics back lt 1 lw 0.6 lc rgb '", colour::grid, "'");
    body.line("set xrange [-0.55:", static_cast<double>(picture.names.size()) - 0.45, "]");
    body.line("set yrange [0:", highest > 0 ? 1.12 * highest : 1, "]");
    body.line("set key outside right top Left reverse samplen 1 spacing 1.3 noenhanced", in_axis_colour);
    body.line("set style fill solid 1 noborder");
    std::string tics;
    for (std::size_t i = 0; i < picture.names.size(); ++i)
        tics += (i > 0 ? ", " : "") + gnuplot_text(tic_text(picture.names[i])) + ' ' + std::to_string(i);
    body.line("set xtics (", tics, ") scale 0 noenhanced");
    if (picture.note.empty()) return;
    body.line("set bmargin 4.5");
    body.line("set label ", gnuplot_text(picture.note),
              " at screen 0.01, 0.03 left noenhanced font note_font", in_axis_colour);
}

}  // namespace

Drawing draw(const BarPicture& picture, const std::filesystem::path& stem) {
    constexpr FigureSize size{1120, 520};
    if (picture.names.empty() || picture.series.empty()) return {Drawn::failed, "there is nothing to draw"};
    // What the bars of one name take of the distance to the next.
    constexpr double taken = 0.84;
    const double width = taken / static_cast<double>(picture.series.size());

    GnuplotScript data;
    double highest = 0;
    for (std::size_t s = 0; s < picture.series.size(); ++s) {
        const auto& bars = picture.series[s].bars;
        data.line("$series", s, " << EOD");
        for (std::size_t i = 0; i < std::min(bars.size(), picture.names.size()); ++i) {
            if (!bars[i]) continue;
            const double x = static_cast<double>(i) + (static_cast<double>(s) + 0.5) * width - taken / 2;
            data.line(x, ' ', bars[i]->value, ' ', bars[i]->low, ' ', bars[i]->high);
            highest = std::max({highest, bars[i]->value, bars[i]->high});
        }
        // A block without rows cannot be drawn; this one is left of the axis.
        data.line("-9 0 0 0");
        data.line("EOD");
    }

    GnuplotScript body;
    put_axes(body, picture, highest);
    std::size_t hues = 0;
    for (std::size_t s = 0; s < picture.series.size(); ++s) {
        const auto& [name, bars, is_reference] = picture.series[s];
        const std::string_view hue =
            is_reference ? colour::faint : colour::series[hues++ % colour::series.size()];
        body.line(s == 0 ? "plot" : "    ", " $series", s, " using 1:2:(", 0.92 * width,
                  ") with boxes lc rgb '", hue, "' title ", gnuplot_text(name), ", \\");
        body.line("     $series", s, " using 1:3:(0):($4 - $3) with vectors nohead lw 1.2 lc rgb '",
                  colour::black, "' notitle, \\");
        body.line("     $series", s,
                  " using 1:4:(sprintf('%.3g', $2)) with labels offset 0,0.6 font note_font",
                  " textcolor rgb '", colour::axis, "' notitle", s + 1 < picture.series.size() ? ", \\" : "");
    }
    return draw_figure(stem, size, data.text(), body);
}

}  // namespace afferent
